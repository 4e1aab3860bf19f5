// What a path atlas keeps of a pixel. Private to the atlas.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "display/buffer/fixed_point.h"
#include "display/buffer/path_atlas.h"
#include "display/buffer/plane.h"
#include "display/services/branches.h"

namespace raylex::display {

/// R + G + B of the samples of each eighth.
struct PathAtlas::Eighths {
    std::array<Int128, parts> sums{};
};

/// One word of one pixel. Most words of most pixels have light of one eighth alone, and their eighths need no memory.
struct PathAtlas::Entry {
    static constexpr std::uint32_t unused = 0;  // the camera alone is no word; and memory comes as zeros
    static constexpr std::uint32_t no_eighth = 0;
    std::array<Int128, 3> light{};
    Eighths* eighths = nullptr;        ///< null: all light is of one eighth
    std::uint32_t word = unused;       ///< twice the word's number, and one more for raster splats
    std::uint32_t eighth = no_eighth;  ///< one more than that eighth's number

    [[nodiscard]] Int128 all_light() const {
        Int128 sum = 0;
        for (const Int128 each : light) static_cast<void>(add_fixed(sum, each));
        return sum;
    }
    template <class Function>
    void for_each_eighth(Function function) const {
        if (eighth != no_eighth && eighths == nullptr) function(eighth - 1, all_light());
        for (std::uint32_t k = 0; eighths != nullptr && k < parts; ++k) function(k, eighths->sums[k]);
    }
};

/// Where parts of entries lie: side by side in large pages, in the order in which they came up. Each in a heap block of
/// its own, a third of what an atlas cost at 32 samples were page faults.
template <class Item>
class PathAtlas::Pool {
  public:
    /// One thread's share of a pool for a while: items are taken by the hundred, what is left is given back.
    class Reserve {
      public:
        explicit Reserve(Pool& pool) : pool_(pool) {}
        Reserve(const Reserve&) = delete;
        Reserve& operator=(const Reserve&) = delete;
        ~Reserve() {
            if (count_ > 0) pool_.put_back({items_.data(), count_});
        }
        /// All zeros.
        Item* take() {
            if (count_ == 0) {
                pool_.take(items_);
                count_ = items_.size();
            }
            return items_[--count_];
        }

      private:
        Pool& pool_;
        std::array<Item*, 128> items_{};
        std::size_t count_ = 0;
    };

    /// Not thread-safe, nor is what follows.
    void give_back(Item* item) {
        *item = {};
        put_back({&item, 1});
    }
    [[nodiscard]] std::uint64_t live() const { return made_ - free_.size(); }
    template <class Function>
    void for_each(Function function) const {
        for (const Plane<Item>& slab : slabs_) {
            const std::size_t used = &slab == &slabs_.back() ? used_of_last_ : slab_items;
            for (const Item& item : slab.values().first(used)) function(item);
        }
    }

  private:
    static constexpr std::size_t slab_items = (std::size_t{8} << 20) / sizeof(Item);
    void take(std::span<Item*> taken) {
        const std::lock_guard lock(mutex_);
        // From the end on, as they are handed out.
        for (std::size_t i = taken.size(); i-- > 0;) {
            if (!free_.empty()) {
                taken[i] = free_.back();
                free_.pop_back();
                continue;
            }
            if (slabs_.empty() || used_of_last_ == slab_items) {
                slabs_.emplace_back().allocate(slab_items);
                used_of_last_ = 0;
            }
            taken[i] = &slabs_.back()[used_of_last_++];
            ++made_;
        }
    }
    void put_back(std::span<Item* const> items) {
        const std::lock_guard lock(mutex_);
        free_.insert(free_.end(), items.begin(), items.end());
    }
    std::mutex mutex_;
    std::vector<Plane<Item>> slabs_;
    std::size_t used_of_last_ = 0;
    std::uint64_t made_ = 0;
    std::vector<Item*> free_;
};

/// Where the ways to a pixel's entries lie, in large pages as well; what was outgrown serves others.
class PathAtlas::SlotPool {
  public:
    /// All null. `count` is a power of two. Thread-safe, as is the other.
    std::span<Entry*> take(std::size_t count) {
        const std::lock_guard lock(mutex_);
        std::vector<Entry**>& outgrown = outgrown_[size_class(count)];
        if (!outgrown.empty()) {
            const std::span<Entry*> taken{outgrown.back(), count};
            outgrown.pop_back();
            std::fill(taken.begin(), taken.end(), nullptr);
            return taken;
        }
        if (slabs_.empty() || slabs_.back().size() - used_of_last_ < count) {
            slabs_.emplace_back().allocate(std::max(count, slab_slots));
            used_of_last_ = 0;
        }
        used_of_last_ += count;
        return slabs_.back().values().subspan(used_of_last_ - count, count);
    }
    void give_back(std::span<Entry*> slots) {
        if (slots.empty()) return;
        const std::lock_guard lock(mutex_);
        outgrown_[size_class(slots.size())].push_back(slots.data());
    }

  private:
    static constexpr std::size_t slab_slots = std::size_t{1} << 18;
    static std::size_t size_class(std::size_t count) { return static_cast<std::size_t>(std::countr_zero(count)); }
    std::mutex mutex_;
    std::vector<Plane<Entry*>> slabs_;
    std::size_t used_of_last_ = 0;
    std::array<std::vector<Entry**>, 64> outgrown_;
};

struct PathAtlas::Pools {
    Pool<Entry> entries;
    Pool<Eighths> eighths;
    SlotPool slots;
};

struct PathAtlas::Reserves {
    Pool<Entry>::Reserve entries;
    Pool<Eighths>::Reserve eighths;
    SlotPool& slots;
    explicit Reserves(Pools& pools) : entries(pools.entries), eighths(pools.eighths), slots(pools.slots) {}

    /// Gives eighths of its own to an entry that has none.
    void spread(Entry& entry) {
        if (entry.eighths != nullptr) return;
        Eighths* const of = eighths.take();
        entry.for_each_eighth([&](std::uint32_t k, Int128 sum) { of->sums[k] = sum; });
        entry.eighths = of;
    }
};

/// The words of a pixel, found by open addressing.
struct PathAtlas::Pixel {
    std::span<Entry*> slots;  ///< null is free
    std::uint32_t count = 0;
    std::array<std::uint32_t, parts> samples{};
    Int128 weight = 0;

    /// Null when the pixel has no such word.
    [[nodiscard]] Entry* find(std::uint32_t word) const { return slots.empty() ? nullptr : slots[slot_of(word)]; }
    void insert(std::uint32_t word, Entry* entry, SlotPool& pool) {
        if (2 * (std::size_t{count} + 1) > slots.size()) {
            const std::span<Entry*> before = slots;
            slots = pool.take(std::max<std::size_t>(8, 2 * before.size()));
            for (Entry* const each : before)
                if (each != nullptr) slots[slot_of(each->word)] = each;
            pool.give_back(before);
        }
        entry->word = word;
        slots[slot_of(word)] = entry;
        ++count;
    }
    /// Entries are all over the memory: the way to them is begun before the first is needed.
    template <class Function>
    void for_each(Function function) const {
        for (Entry* const entry : slots)
            if (entry != nullptr) __builtin_prefetch(entry);
        for (Entry* const entry : slots)
            if (entry != nullptr) function(*entry);
    }
    [[nodiscard]] std::uint64_t bytes() const { return sizeof(Pixel) + slots.size_bytes(); }

    /// Begins the way to a word that is going to be looked for.
    void prefetch(std::uint32_t word) const {
        if (!slots.empty()) __builtin_prefetch(&slots[mix64(word) & (slots.size() - 1)]);
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
