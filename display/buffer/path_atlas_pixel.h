// What a path atlas keeps of a pixel. Private to the atlas.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "display/buffer/path_atlas.h"
#include "display/services/branches.h"

namespace raylex::display {

/// One word of one pixel. `word` is twice the word's number, and one more for raster splats.
struct PathAtlas::Entry {
    std::array<Int128, 3 + parts> sums{};
    std::uint32_t word = 0;
};

/// The words of a pixel, found by open addressing: slots hold places in `entries` and one more, 0 is free.
struct PathAtlas::Pixel {
    std::vector<Entry> entries;
    std::vector<std::uint32_t> slots;
    Int128 weight = 0;
    std::array<std::uint32_t, parts> samples{};

    Entry& entry(std::uint32_t word) {
        if (2 * (entries.size() + 1) > slots.size()) grow();
        const std::size_t at = slot_of(word);
        if (slots[at] != 0) return entries[slots[at] - 1];
        if (entries.size() == entries.capacity()) entries.reserve(entries.size() + entries.size() / 4 + 2);
        entries.push_back({{}, word});
        slots[at] = static_cast<std::uint32_t>(entries.size());
        return entries.back();
    }
    [[nodiscard]] std::size_t slot_of(std::uint32_t word) const {
        const std::size_t mask = slots.size() - 1;
        std::size_t at = mix64(word) & mask;
        while (slots[at] != 0 && entries[slots[at] - 1].word != word) at = (at + 1) & mask;
        return at;
    }
    void grow() {
        slots.assign(std::max<std::size_t>(8, 2 * slots.size()), 0);
        for (std::size_t i = 0; i < entries.size(); ++i)
            slots[slot_of(entries[i].word)] = static_cast<std::uint32_t>(i + 1);
    }
    [[nodiscard]] std::uint64_t bytes() const {
        return sizeof(Pixel) + entries.capacity() * sizeof(Entry) + slots.capacity() * sizeof(std::uint32_t);
    }
};

}  // namespace raylex::display
