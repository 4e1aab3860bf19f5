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
    return suffix;
}

PathSuffix LpeServices::prepend(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event) const {
    PathSuffix longer = prepend_states(pool, suffix, event);
    longer.length_ = static_cast<std::uint16_t>(suffix.length_ + 1);
    const LobePart all{event, Rgb(1)};
    longer.path_ = pool.keep_path({&all, 1}, &suffix);
    return longer;
}

PathSuffix LpeServices::prepend(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                                std::uint64_t key) {
    PathSuffix longer = prepend_states(pool, suffix, parts, key);
    longer.length_ = static_cast<std::uint16_t>(suffix.length_ + 1);
    longer.path_ = pool.keep_path(parts, &suffix);
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

PathSuffix LpeServices::prepend_states(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event) const {
    const LobePart all{event, Rgb(1)};
    if (pool.reversed_ == nullptr) return pool.keep({&all, 1}, &suffix);
    if (!suffix.whole_) return prepend_split(pool, suffix, {&all, 1}, 0).suffix;
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
                                       std::uint64_t key) {
    if (pool.reversed_ == nullptr) return pool.keep(parts, &suffix);
    if (suffix.branches_ == 0 || parts.size() == 1)
        return parts.empty() ? suffix : prepend_states(pool, suffix, parts[0].event);
    if (parts.empty()) return {};
    const SplitSuffix split = prepend_split(pool, suffix, parts, key);
    if (split.overflow) ++overflow_count_;
    return split.suffix;
}

LpeServices::SplitSuffix LpeServices::prepend_split(PathSuffixes& pool, const PathSuffix& suffix,
                                                    std::span<const LobePart> parts, std::uint64_t key) const {
    const lpe::ReversedProgram& reversed = *pool.reversed_;
    ChoiceNumbers numbers([&] { return mix_bits(mix_bits(seed_ + golden_gamma) ^ key); });
    Fractions fractions(parts);
    if (attribution_ == Attribution::picked) fractions.pick(numbers.next());
    BranchList branches(reversed.word_count());
    branches.split({pool.states(suffix), pool.shares(suffix), suffix.branches_, reversed.word_count()}, parts,
                   fractions, PathSuffixes::capacity, numbers,
                   [&](const lpe::State* from, lpe::EventClass event, lpe::State* to) {
                       return reversed.prepend(from, event, to);
                   });
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
    if (pool.reversed_ == nullptr) {
        if (!suffix.live()) tracker.count_ = 0;
        for (std::uint32_t at = suffix.state_; tracker.count_ != 0;) {
            const PathSuffixes::Event& event = pool.events_[at];
            move_states(tracker, {pool.parts_.data() + event.first, event.count});
            if (event.next == std::exchange(at, event.next)) return;
        }
        return;
    }
    const lpe::ReversedProgram& reversed = *pool.reversed_;
    if (tracker.whole_ && suffix.whole_) {
        lpe::State* const state = tracker.state_.data();
        tracker.count_ = suffix.branches_ != 0 && reversed.connect(state, pool.states(suffix), state);
        return;
    }
    // One move for each event, so that each connection of a camera vertex draws its own numbers.
    tracker.moves_ = static_cast<std::uint16_t>(tracker.moves_ + suffix.length_);
    ChoiceNumbers numbers([&] { return random_key(tracker, {}); });
    const std::size_t target = branch_limit(tracker);
    const Branches of_camera = branches_of(tracker);
    const Branches of_light{pool.states(suffix), pool.shares(suffix), suffix.branches_, reversed.word_count()};
    BranchList joined(of_camera.words);
    const auto shrink = [&] {
        joined.collapse(target, numbers.next());
        joined.overflow = true;
    };
    joined.whole = false;
    for (std::size_t i = 0; i < of_camera.count; ++i)
        for (std::size_t k = 0; k < of_light.count; ++k) {
            if (!joined.has_room_for(1)) shrink();
            lpe::State* const whole = joined.candidates();
            if (!reversed.connect(of_camera.state_of(i), of_light.state_of(k), whole)) continue;
            const RgbD share = of_camera.share_of(i) * of_light.share_of(k);
            if (share.r != 0 || share.g != 0 || share.b != 0) joined.add(whole, share);
        }
    if (joined.count > target) shrink();
    take(tracker, joined);
}

}  // namespace raylex::display
