// What a path atlas keeps of a pixel. Private to the atlas.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "display/buffer/frame_buffer_storage.h"
#include "display/buffer/path_atlas.h"
#include "display/services/branches.h"

namespace raylex::display {

/// One word of one pixel. `word` is twice the word's number, and one more for raster splats.
struct PathAtlas::Entry {
    static constexpr std::uint32_t unused = 0;  // the camera alone is no word; and memory comes as zeros
    std::array<Int128, 3 + parts> sums{};
    std::uint32_t word = unused;
};

/// Where entries lie: side by side in large pages, in the order in which they came up. Each in a heap block of its own,
/// a third of what an atlas cost at 32 samples were page faults.
class PathAtlas::EntryPool {
  public:
    /// As many entries as there is room for in `taken`, all zeros. Thread-safe; once a batch.
    void take(std::span<Entry*> taken) {
        const std::lock_guard lock(mutex_);
        for (Entry*& entry : taken) {
            if (!given_back_.empty()) {
                entry = given_back_.back();
                given_back_.pop_back();
                continue;
            }
            if (used_of_last_ == slab_entries || slabs_.empty()) {
                slabs_.emplace_back().allocate(slab_entries);
                used_of_last_ = 0;
            }
            entry = &slabs_.back()[used_of_last_++];
        }
        live_ += taken.size();
    }
    /// Not thread-safe, nor is what follows.
    void give_back(Entry* entry) {
        *entry = {};
        given_back_.push_back(entry);
        --live_;
    }
    [[nodiscard]] std::uint64_t live() const { return live_; }
    template <class Function>
    void for_each(Function function) const {
        for (const Plane<Entry>& slab : slabs_) {
            const std::size_t used = &slab == &slabs_.back() ? used_of_last_ : slab_entries;
            for (const Entry& entry : slab.values().first(used))
                if (entry.word != Entry::unused) function(entry);
        }
    }

  private:
    static constexpr std::size_t slab_entries = (std::size_t{8} << 20) / sizeof(Entry);
    std::mutex mutex_;
    std::vector<Plane<Entry>> slabs_;
    std::size_t used_of_last_ = 0;
    std::vector<Entry*> given_back_;
    std::uint64_t live_ = 0;
};

/// The words of a pixel, found by open addressing.
struct PathAtlas::Pixel {
    std::vector<Entry*> slots;  ///< null is free
    std::uint32_t count = 0;
    std::array<std::uint32_t, parts> samples{};
    Int128 weight = 0;

    /// Null when the pixel has no such word.
    [[nodiscard]] Entry* find(std::uint32_t word) const { return slots.empty() ? nullptr : slots[slot_of(word)]; }
    void insert(std::uint32_t word, Entry* entry) {
        if (2 * (std::size_t{count} + 1) > slots.size()) {
            std::vector<Entry*> before(std::max<std::size_t>(8, 2 * slots.size()), nullptr);
            before.swap(slots);
            for (Entry* const each : before)
                if (each != nullptr) slots[slot_of(each->word)] = each;
        }
        entry->word = word;
        slots[slot_of(word)] = entry;
        ++count;
    }
    template <class Function>
    void for_each(Function function) const {
        for (Entry* const entry : slots)
            if (entry != nullptr) function(*entry);
    }
    [[nodiscard]] std::uint64_t bytes() const {
        return sizeof(Pixel) + count * sizeof(Entry) + slots.capacity() * sizeof(Entry*);
    }

  private:
    [[nodiscard]] std::size_t slot_of(std::uint32_t word) const {
        const std::size_t mask = slots.size() - 1;
        std::size_t at = mix64(word) & mask;
        while (slots[at] != nullptr && slots[at]->word != word) at = (at + 1) & mask;
        return at;
    }
};

}  // namespace raylex::display
