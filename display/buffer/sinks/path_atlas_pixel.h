// The content of one pixel of a path atlas. Private to the atlas.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <span>
#include <vector>

#include "display/buffer/fixed_point.h"
#include "display/buffer/plane.h"
#include "display/buffer/sinks/path_atlas.h"
#include "display/services/samples/branches.h"
#include "display/services/split_mix.h"

namespace raylex::display {

/// Prefetches memory. The empty asm statement is for GCC 12, which treats functions that only prefetch as having no
/// effect, and removes their calls.
inline void prefetch(const void* memory) {
    __builtin_prefetch(memory);
    asm volatile("");
}

/// R + G + B of the samples in each eighth.
struct PathAtlas::Eighths {
    std::array<Int128, parts> sums{};
};

/// Storage for parts of entries: contiguous in large pages, in order of creation, referenced by numbers. With one heap
/// block per part, page faults caused a third of the cost of an atlas at 32 samples.
template <class Item>
class PathAtlas::Pool {
  public:
    using Number = std::uint32_t;
    static constexpr Number none = 0;                                       ///< refers to no item
    static constexpr Number most = std::numeric_limits<Number>::max() / 2;  ///< Slot uses the highest bit

    /// Items reserved by one thread: taken by the hundred; unused ones are returned.
    class Reserve {
      public:
        explicit Reserve(Pool& pool) : pool_(pool) {}
        Reserve(const Reserve&) = delete;
        Reserve& operator=(const Reserve&) = delete;
        ~Reserve() {
            if (count_ > 0) pool_.put_back({numbers_.data(), count_});
        }
        /// The number of a zeroed item.
        Number take() {
            if (count_ == 0) {
                pool_.take(numbers_);
                count_ = numbers_.size();
            }
            return numbers_[--count_];
        }
        void give_back(Number number) {
            pool_[number] = {};
            if (count_ == numbers_.size()) {
                pool_.put_back(numbers_);
                count_ = 0;
            }
            numbers_[count_++] = number;
        }
        [[nodiscard]] Item& operator[](Number number) const { return pool_[number]; }

      private:
        Pool& pool_;
        std::array<Number, 128> numbers_{};
        std::size_t count_ = 0;
    };

    Pool() {
        slabs_.reserve(std::size_t{most} / slab_items + 1);
    }  // so that slabs do not move while other threads
       // read
    [[nodiscard]] Item& operator[](Number number) { return slabs_[number / slab_items][number % slab_items]; }
    [[nodiscard]] const Item& operator[](Number number) const {
        return slabs_[number / slab_items][number % slab_items];
    }

    /// This and the following functions are not thread-safe.
    [[nodiscard]] std::uint64_t live() const { return made_ - free_.size(); }
    template <class Function>
    void for_each(Function function) const {
        for (std::uint64_t number = 1; number <= made_; ++number) function((*this)[static_cast<Number>(number)]);
    }

  private:
    static constexpr std::size_t slab_items = (std::size_t{8} << 20) / sizeof(Item);
    void take(std::span<Number> taken) {
        const std::lock_guard lock(mutex_);
        // From the end, the order in which they are handed out.
        for (std::size_t i = taken.size(); i-- > 0;) {
            if (!free_.empty()) {
                taken[i] = free_.back();
                free_.pop_back();
                continue;
            }
            if (made_ == most) throw std::bad_alloc();
            if (++made_ / slab_items == slabs_.size()) slabs_.emplace_back().allocate(slab_items);
            taken[i] = static_cast<Number>(made_);
        }
    }
    void put_back(std::span<const Number> numbers) {
        const std::lock_guard lock(mutex_);
        free_.insert(free_.end(), numbers.begin(), numbers.end());
    }
    std::mutex mutex_;
    std::vector<Plane<Item>> slabs_;
    std::uint64_t made_ = 0;  // the number of the last item
    std::vector<Number> free_;
};

/// One word of one pixel. In most pixels most words have light of a single eighth, and need no memory for eighths.
struct PathAtlas::Entry {
    static constexpr std::uint32_t unused = 0;  // the camera alone is not a word; new memory is zero
    static constexpr std::uint32_t no_eighth = 0;
    std::array<Int128, 3> light{};
    std::uint32_t eighths = Pool<Eighths>::none;  ///< none: all light belongs to one eighth
    std::uint32_t word = unused;                  ///< twice the word's number, plus one for raster splats
    std::uint32_t eighth = no_eighth;             ///< the number of that eighth plus one

    [[nodiscard]] bool is_spread() const { return eighths != Pool<Eighths>::none; }
    [[nodiscard]] Int128 all_light() const {
        Int128 sum = 0;
        for (const Int128 each : light) static_cast<void>(add_fixed(sum, each));
        return sum;
    }
    /// `of`: the storage of eighths, here and below.
    template <class Pool>
    void prefetch_eighths(const Pool& of) const {
        if (!is_spread()) return;
        display::prefetch(&of[eighths]);
        display::prefetch(&of[eighths].sums.back());
    }
    template <class Pool, class Function>
    void for_each_eighth(const Pool& of, Function function) const {
        if (is_spread())
            for (std::uint32_t k = 0; k < parts; ++k) function(k, of[eighths].sums[k]);
        else if (eighth != no_eighth) function(eighth - 1, all_light());
    }
};

/// A word whose light came once and in one eighth, stored unrounded in half the memory of an entry. In a foggy scene
/// half of the words stay like this.
struct PathAtlas::Single {
    std::array<double, 3> light{};
    std::uint32_t word = Entry::unused;       ///< as in Entry
    std::uint32_t eighth = Entry::no_eighth;  ///< as in Entry

    [[nodiscard]] Entry as_entry(int exponent) const {
        Entry entry;
        entry.word = word;
        entry.eighth = eighth;
        // The frame buffer rejects and counts light out of range.
        for (std::size_t c = 0; c < 3; ++c) static_cast<void>(to_fixed(light[c], exponent, entry.light[c]));
        return entry;
    }
};

/// The location of a word of a pixel.
struct PathAtlas::Slot {
    static constexpr std::uint32_t of_single = std::uint32_t{1} << 31;
    std::uint32_t word = Entry::unused;       ///< as in Entry; unused: the slot is free
    std::uint32_t place = Pool<Entry>::none;  ///< index into entries, or with of_single into singles

    [[nodiscard]] bool is_single() const { return (place & of_single) != 0; }
    [[nodiscard]] std::uint32_t single() const { return place & ~of_single; }
};

/// Storage for the slots of pixels, in large pages too. Slot arrays that a pixel has outgrown are reused.
class PathAtlas::SlotPool {
  public:
    /// Returns `count` free slots; `count` is a power of two. Thread-safe, like give_back().
    std::span<Slot> take(std::size_t count) {
        const std::lock_guard lock(mutex_);
        std::vector<Slot*>& outgrown = outgrown_[size_class(count)];
        if (!outgrown.empty()) {
            const std::span<Slot> taken{outgrown.back(), count};
            outgrown.pop_back();
            std::fill(taken.begin(), taken.end(), Slot{});
            return taken;
        }
        if (slabs_.empty() || slabs_.back().size() - used_of_last_ < count) {
            slabs_.emplace_back().allocate(std::max(count, slab_slots));
            used_of_last_ = 0;
        }
        used_of_last_ += count;
        return slabs_.back().values().subspan(used_of_last_ - count, count);
    }
    void give_back(std::span<Slot> slots) {
        if (slots.empty()) return;
        const std::lock_guard lock(mutex_);
        outgrown_[size_class(slots.size())].push_back(slots.data());
    }

  private:
    static constexpr std::size_t slab_slots = std::size_t{1} << 18;
    static std::size_t size_class(std::size_t count) { return static_cast<std::size_t>(std::countr_zero(count)); }
    std::mutex mutex_;
    std::vector<Plane<Slot>> slabs_;
    std::size_t used_of_last_ = 0;
    std::array<std::vector<Slot*>, 64> outgrown_;
};

struct PathAtlas::Pools {
    const int exponent;  ///< the quantum of light is 2^exponent
    Pool<Single> singles;
    Pool<Entry> entries;
    Pool<Eighths> eighths;
    SlotPool slots;
    explicit Pools(int quantum_exponent) : exponent(quantum_exponent) {}

    [[nodiscard]] std::uint64_t words() const { return singles.live() + entries.live(); }
    [[nodiscard]] std::uint64_t bytes() const {
        return singles.live() * sizeof(Single) + entries.live() * sizeof(Entry) + eighths.live() * sizeof(Eighths);
    }
    /// Visits the entries of all pixels in order of storage. Not thread-safe.
    void for_each(auto function) const {
        singles.for_each([&](const Single& single) { function(single.as_entry(exponent)); });
        entries.for_each(function);
    }
};

struct PathAtlas::Reserves {
    Pool<Single>::Reserve singles;
    Pool<Entry>::Reserve entries;
    Pool<Eighths>::Reserve eighths;
    SlotPool& slots;
    const int exponent;
    explicit Reserves(Pools& pools)
        : singles(pools.singles),
          entries(pools.entries),
          eighths(pools.eighths),
          slots(pools.slots),
          exponent(pools.exponent) {}

    /// The word's entry; converts its single light if necessary.
    Entry& entry(Slot& slot) {
        if (slot.is_single()) {
            const std::uint32_t single = slot.single();
            slot.place = entries.take();
            entries[slot.place] = singles[single].as_entry(exponent);
            singles.give_back(single);
        }
        return entries[slot.place];
    }

    /// Gives an entry memory for eighths if it has none.
    void spread(Entry& entry) {
        if (entry.is_spread()) return;
        const std::uint32_t own = eighths.take();
        entry.for_each_eighth(eighths, [&](std::uint32_t k, Int128 sum) { eighths[own].sums[k] = sum; });
        entry.eighths = own;
    }
};

/// The words of a pixel in a hash table with open addressing.
struct PathAtlas::Pixel {
    std::span<Slot> slots;
    std::uint32_t count = 0;
    std::array<std::uint32_t, parts> samples{};
    Int128 weight = 0;

    /// The slot of a word; null if the pixel does not have it.
    [[nodiscard]] Slot* find(std::uint32_t word) const {
        if (slots.empty()) return nullptr;
        Slot& slot = slots[slot_of(word)];
        return slot.word == Entry::unused ? nullptr : &slot;
    }
    /// Inserts a word that the pixel does not have.
    Slot& insert(Slot slot, SlotPool& pool) {
        if (4 * (std::size_t{count} + 1) > 3 * slots.size()) {
            const std::span<Slot> before = slots;
            slots = pool.take(std::max<std::size_t>(8, 2 * before.size()));
            for (const Slot each : before)
                if (each.word != Entry::unused) slots[slot_of(each.word)] = each;
            pool.give_back(before);
        }
        ++count;
        return slots[slot_of(slot.word)] = slot;
    }
    /// Entries and their eighths are scattered in memory, so all are prefetched before the first one is used.
    void for_each(const Pools& pools, auto function) const {
        const auto for_each_slot = [&](auto of_single, auto of_entry) {
            for (const Slot slot : slots) {
                if (slot.word == Entry::unused) continue;
                if (slot.is_single()) of_single(pools.singles[slot.single()]);
                else of_entry(pools.entries[slot.place]);
            }
        };
        for_each_slot([](const Single& single) { display::prefetch(&single); },
                      [](const Entry& entry) { display::prefetch(&entry); });
        for_each_slot([](const Single&) {}, [&](const Entry& entry) { entry.prefetch_eighths(pools.eighths); });
        for_each_slot([&](const Single& single) { function(single.as_entry(pools.exponent)); }, function);
    }
    [[nodiscard]] std::uint64_t bytes() const { return sizeof(Pixel) + slots.size_bytes(); }

    /// Prefetches the slot of a word that will be looked up.
    void prefetch_slot(std::uint32_t word) const {
        if (!slots.empty()) display::prefetch(&slots[mix_bits(word) & (slots.size() - 1)]);
    }
    /// Prefetches the word's light, once its slot is loaded.
    void prefetch_entry(std::uint32_t word, const Pools& pools) const {
        const Slot* const slot = find(word);
        if (slot == nullptr) return;
        if (slot->is_single()) display::prefetch(&pools.singles[slot->single()]);
        else display::prefetch(&pools.entries[slot->place]);
    }

  private:
    [[nodiscard]] std::size_t slot_of(std::uint32_t word) const {
        const std::size_t mask = slots.size() - 1;
        std::size_t at = mix_bits(word) & mask;
        while (slots[at].word != Entry::unused && slots[at].word != word) at = (at + 1) & mask;
        return at;
    }
};

}  // namespace raylex::display
