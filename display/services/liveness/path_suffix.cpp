#include "display/services/liveness/path_suffix.h"

#include <algorithm>
#include <array>
#include <utility>

#include "display/services/samples/branches.h"
#include "display/services/split_mix.h"

namespace raylex::display {

PathSuffix PathSuffixes::keep(std::span<const LobePart> parts, const PathSuffix* next) {
    PathSuffix suffix;
    suffix.state_ = static_cast<std::uint32_t>(events_.size());
    suffix.branches_ = next == nullptr ? 1 : next->branches_;
    if (!suffix.live() || parts.empty()) return {};
    events_.push_back({next == nullptr ? suffix.state_ : next->state_, static_cast<std::uint32_t>(parts_.size()),
                       static_cast<std::uint32_t>(parts.size())});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return suffix;
}

std::uint32_t PathSuffixes::keep_path(std::span<const LobePart> parts, const PathSuffix* next) {
    if (!keeps_paths_ || parts.empty() || (next != nullptr && next->path_ == 0)) return 0;
    const auto place = static_cast<std::uint32_t>(events_.size());
    events_.push_back({next == nullptr ? place : next->path_ - 1, static_cast<std::uint32_t>(parts_.size()),
                       static_cast<std::uint32_t>(parts.size())});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return place + 1;
}

PathSuffix LpeServices::begin(PathSuffixes& pool, lpe::EventClass terminal) const {
    PathSuffix suffix = begin_states(pool, terminal);
    const LobePart only{terminal, Rgb(1)};
    suffix.path_ = pool.keep_path({&only, 1}, nullptr);
    if (pool.layers_) suffix.layers_ = pool.layers_->add(begin_states(*pool.layers_, terminal));
    return suffix;
}

PathSuffix LpeServices::prepend(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event) const {
    PathSuffix longer = prepend_states(pool, suffix, event);
    longer.length_ = static_cast<std::uint16_t>(suffix.length_ + 1);
    const LobePart all{event, Rgb(1)};
    longer.path_ = pool.keep_path({&all, 1}, &suffix);
    if (pool.layers_ && longer.live()) {
        const Branches of_class = pool.branches_of(longer);
        longer.layers_ = pool.layers_->add(prepend_states(*pool.layers_, pool.layers_of(suffix), event, &of_class));
    }
    return longer;
}

PathSuffix LpeServices::prepend(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                                std::uint64_t key) {
    PathSuffix longer = prepend_states(pool, suffix, parts, key);
    longer.length_ = static_cast<std::uint16_t>(suffix.length_ + 1);
    longer.path_ = pool.keep_path(parts, &suffix);
    if (pool.layers_ && longer.live()) {
        const Branches of_class = pool.branches_of(longer);
        longer.layers_ =
            pool.layers_->add(prepend_states(*pool.layers_, pool.layers_of(suffix), parts, key, &of_class));
    }
    return longer;
}

void LpeServices::connect(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix) {
    for (std::uint32_t at = suffix.path_; path_strings_ != nullptr && at != 0;) {
        const PathSuffixes::Event& event = pool.events_[at - 1];
        keep_move(tracker, {pool.parts_.data() + event.first, event.count});
        at = event.next + 1 == at ? 0 : event.next + 1;
    }
    connect_states(tracker, pool, suffix);
}

PathSuffix LpeServices::begin_states(PathSuffixes& pool, lpe::EventClass terminal) const {
    if (pool.reversed_ == nullptr) {
        const LobePart only{terminal, Rgb(1)};
        return pool.keep({&only, 1}, nullptr);
    }
    PathSuffix suffix;
    suffix.state_ = static_cast<std::uint32_t>(pool.states_.size());
    const std::span<const lpe::State> end = pool.reversed_->starts();
    pool.states_.insert(pool.states_.end(), end.begin(), end.end());
    suffix.branches_ = 1;
    return prepend_states(pool, suffix, terminal);
}

PathSuffix LpeServices::prepend_states(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event,
                                       const Branches* of_class) const {
    const LobePart all{event, Rgb(1)};
    if (pool.reversed_ == nullptr) return pool.keep({&all, 1}, &suffix);
    if (!suffix.whole_) return prepend_split(pool, suffix, {&all, 1}, 0, of_class).suffix;
    PathSuffix longer = suffix;
    if (suffix.branches_ == 0) return longer;
    const std::size_t at = pool.states_.size();
    longer.state_ = static_cast<std::uint32_t>(at);
    pool.states_.resize(at + pool.reversed_->word_count());
    // A program without channels, where only an atlas was requested, has no states to point at.
    longer.branches_ = pool.reversed_->prepend(pool.states(suffix), event, pool.states_.data() + at);
    return longer;
}

PathSuffix LpeServices::prepend_states(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                                       std::uint64_t key, const Branches* of_class) {
    if (pool.reversed_ == nullptr) return pool.keep(parts, &suffix);
    if (suffix.branches_ == 0 || parts.size() == 1)
        return parts.empty() ? suffix : prepend_states(pool, suffix, parts[0].event, of_class);
    if (parts.empty()) return {};
    const SplitSuffix split = prepend_split(pool, suffix, parts, key, of_class);
    if (split.overflow) ++overflow_count_;
    return split.suffix;
}

LpeServices::SplitSuffix LpeServices::prepend_split(PathSuffixes& pool, const PathSuffix& suffix,
                                                    std::span<const LobePart> parts, std::uint64_t key,
                                                    const Branches* of_class) const {
    const lpe::ReversedProgram& reversed = *pool.reversed_;
    const auto make_key = [&] { return mix_bits(mix_bits(seed_ + golden_gamma) ^ key); };
    ChoiceNumbers numbers(make_key);
    Fractions fractions(parts);
    if (attribution_ == Attribution::picked) fractions.pick(numbers.next());
    BranchList branches(reversed.word_count(), of_class != nullptr);
    const std::size_t most = of_class != nullptr    ? Tracker::layer_capacity
                             : setup_.is_of_class() ? Tracker::class_capacity
                                                    : PathSuffixes::capacity;
    if (of_class != nullptr) key = mix_bits(key);  // the class picks the same lobe; all else is independent of it
    ChoiceNumbers of_layers(make_key);
    branches.split(pool.branches_of(suffix), parts, fractions, most, of_class != nullptr ? of_layers : numbers,
                   [&](const lpe::State* from, lpe::EventClass event, lpe::State* to) {
                       return reversed.prepend(from, event, to) && (of_class == nullptr || of_class->has_state(to[0]));
                   });
    if (of_class != nullptr) branches.fit(*of_class);
    SplitSuffix result;
    result.overflow = branches.overflow;
    PathSuffix& longer = result.suffix;
    longer.state_ = static_cast<std::uint32_t>(pool.states_.size());
    longer.share_ = static_cast<std::uint32_t>(pool.shares_.size());
    longer.branches_ = static_cast<std::uint8_t>(branches.count);
    longer.whole_ = branches.whole;
    const auto states = branches.state.begin();
    pool.states_.insert(pool.states_.end(), states,
                        states + static_cast<std::ptrdiff_t>(branches.count * reversed.word_count()));
    const auto shares = branches.share.begin();
    if (!branches.whole)
        pool.shares_.insert(pool.shares_.end(), shares, shares + static_cast<std::ptrdiff_t>(branches.count));
    return result;
}

void LpeServices::connect_states(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix) {
    if (tracker.count_ == 0) return;
    if (pool.reversed_ == nullptr) return move_along(tracker, pool, suffix);
    if (pool.layers_) connect_divided(tracker, pool, suffix);
    else connect_main(tracker, pool, suffix);
}

/// Connects the class, then the channels beside it.
void LpeServices::connect_divided(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix) {
    if (!suffix.live()) {
        tracker.count_ = tracker.layer_count_ = 0;
        return;
    }
    const PathSuffixes& of_layers = *pool.layers_;
    const PathSuffix layers = pool.layers_of(suffix);
    if (tracker.whole_ && suffix.whole_ && layers.whole_ && of_layers.reversed_ != nullptr)
        return connect_main(tracker, of_layers, layers);
    if (tracker.whole_) tracker.divide();
    const Tracker camera = tracker;
    connect_main(tracker, pool, suffix);
    if (tracker.count_ == 0) tracker.layer_count_ = 0;
    else connect_layers(camera, of_layers, layers, tracker);
}

void LpeServices::move_along(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix) {
    if (!suffix.live()) tracker.count_ = tracker.layer_count_ = 0;
    for (std::uint32_t at = suffix.state_; tracker.count_ != 0;) {
        const PathSuffixes::Event& event = pool.events_[at];
        move_states(tracker, {pool.parts_.data() + event.first, event.count});
        if (event.next == std::exchange(at, event.next)) return;
    }
}

void LpeServices::connect_main(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix) {
    const lpe::ReversedProgram& reversed = *pool.reversed_;
    if (tracker.whole_ && suffix.whole_) {
        lpe::State* const state = tracker.state_.data();
        tracker.count_ = suffix.branches_ != 0 && reversed.connect(state, pool.states(suffix), state);
        return;
    }
    // One move for each event, so that each connection of a camera vertex draws its own numbers.
    tracker.moves_ = static_cast<std::uint16_t>(tracker.moves_ + suffix.length_);
    ChoiceNumbers numbers([&] { return random_key(tracker, {}); });
    BranchList joined(tracker.groups_);
    joined.join(tracker.branches_of_main(), pool.branches_of(suffix), branch_limit(tracker), numbers,
                [&](const lpe::State* camera, const lpe::State* light, lpe::State* whole) {
                    return reversed.connect(camera, light, whole);
                });
    take(tracker, joined);
}

/// Connects the layers of `camera` with a suffix. `connected` is the tracker whose class is already connected.
void LpeServices::connect_layers(const Tracker& camera, const PathSuffixes& pool, const PathSuffix& suffix,
                                 Tracker& connected) {
    const Branches of_class = connected.branches_of_main();
    ChoiceNumbers numbers([&] { return mix_bits(random_key(connected, {})); });
    BranchList one(camera.layer_groups_, true), other(camera.layer_groups_, true);
    BranchList *joined = &one, *before = &other;
    if (pool.reversed_ != nullptr) {
        joined->join(camera.branches_of_layers(), pool.branches_of(suffix), Tracker::layer_capacity, numbers,
                     [&](const lpe::State* of_camera, const lpe::State* of_light, lpe::State* whole) {
                         return pool.reversed_->connect(of_camera, of_light, whole);
                     });
    } else {
        // Moves along the events, where the class is in more states than a tracker keeps.
        Branches from = camera.branches_of_layers();
        const PathSuffixes::Event* event = &pool.events_[suffix.state_];
        for (bool is_last = false; !is_last; event = &pool.events_[event->next]) {
            const std::span<const LobePart> parts(pool.parts_.data() + event->first, event->count);
            is_last = &pool.events_[event->next] == event;
            std::swap(before, joined);
            joined->clear();
            Fractions fractions(parts);
            if (attribution_ == Attribution::picked) fractions.pick(numbers.next());
            joined->split(from, parts, fractions, is_last ? Tracker::layer_capacity : 3 * Tracker::capacity, numbers,
                          [&](const lpe::State* at, lpe::EventClass moved, lpe::State* to) {
                              const bool lives = setup_.program_.view().advance(at, moved, to);
                              if (is_last) to[0] = of_class.state[0];  // its accepting states are one
                              return lives;
                          });
            from = joined->branches();
        }
    }
    joined->fit(of_class);
    put(connected.layers(), *joined);
}

}  // namespace raylex::display
