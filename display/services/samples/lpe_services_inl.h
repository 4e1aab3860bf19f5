// The inline functions of the LPE services, for integrators. Include lpe_services.h instead.
#pragma once

#include "display/services/samples/lpe_services.h"

#include <algorithm>
#include <cmath>

namespace raylex::display {

inline void Tracker::copy(const Tracker& other) noexcept {
    row_ = other.row_;
    path_ = other.path_;
    moves_ = other.moves_;
    count_ = other.count_;
    groups_ = other.groups_;
    whole_ = other.whole_;
    held_out_ = other.held_out_;
    const std::size_t states = std::size_t{count_} * groups_;
    for (std::size_t i = 0; i < states; ++i) state_[i] = other.state_[i];
    if (whole_) return;
    for (std::size_t i = 0; i < count_; ++i) share_[i] = other.share_[i];
}

inline Tracker LpeServices::begin(int row) const {
    Tracker tracker;
    tracker.row_ = row;
    tracker.groups_ = static_cast<std::uint8_t>(setup_.first_states_.size());
    tracker.count_ = tracker.groups_ == 0 ? 0 : 1;
    for (std::size_t group = 0; group < tracker.groups_; ++group) tracker.state_[group] = setup_.first_states_[group];
    return tracker;
}

inline void LpeServices::move_states(Tracker& tracker, lpe::EventClass event) const {
    if (tracker.count_ == 0) return;
    ++tracker.moves_;
    const lpe::ProgramView& program = setup_.program_.view();
    const std::size_t words = tracker.groups_;
    if (tracker.whole_) {  // one branch, whole
        if (words == 1) {
            tracker.state_[0] = program.next(tracker.state_[0], event);
            tracker.count_ = tracker.state_[0] != lpe::Program::dead;
        } else {
            tracker.count_ = program.advance(tracker.state_.data(), event, tracker.state_.data());
        }
        return;
    }
    std::size_t kept = 0;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        lpe::State* to = &tracker.state_[kept * words];
        if (words == 1) {
            to[0] = program.next(tracker.state_[branch], event);
            if (to[0] == lpe::Program::dead) continue;
        } else if (!program.advance(&tracker.state_[branch * words], event, to)) {
            continue;
        }
        std::size_t at = 0;
        while (at < kept && !std::equal(to, to + words, &tracker.state_[at * words])) ++at;
        const bool merge = at < kept;
        const BranchShare share = tracker.share_[branch];
        BranchShare& sum = tracker.share_[at];
        sum = merge ? BranchShare{sum.r + share.r, sum.g + share.g, sum.b + share.b} : share;
        if (!merge) ++kept;
    }
    tracker.count_ = static_cast<std::uint8_t>(kept);
}

inline void LpeServices::move_states(Tracker& tracker, std::span<const LobePart> parts) {
    if (tracker.count_ == 0) return;
    if (parts.size() == 1) move_states(tracker, parts[0].event);
    else split(tracker, parts);
}

inline void LpeServices::move(Tracker& tracker, lpe::EventClass event) const {
    if (path_strings_ != nullptr) [[unlikely]]
        keep_move(tracker, event);
    move_states(tracker, event);
}

inline void LpeServices::move(Tracker& tracker, std::span<const LobePart> parts) {
    if (path_strings_ != nullptr) [[unlikely]]
        keep_move(tracker, parts);
    move_states(tracker, parts);
}

/// Returns whether a component is above `largest`, or NaN.
inline bool out_of_range(const Rgb& value, float largest) {
    const auto outside = [largest](float v) { return !(std::abs(v) <= largest); };
    return outside(value.r) || outside(value.g) || outside(value.b);
}

inline void LpeServices::contribute(const Rgb& value, Technique technique, const Tracker& tracker) {
    if (value.is_black()) return;  // usual for a light sample behind the surface
    if (slow_path_) [[unlikely]] {
        contribute(value, technique, tracker, EmitterSample{value, value, 1, false});
        return;
    }
    if (out_of_range(value, setup_.largest_contribution_)) {
        reject(value, tracker);
        return;
    }
    const std::size_t at = 3 * static_cast<std::size_t>(tracker.row_);
    const double r = static_cast<double>(value.r), g = static_cast<double>(value.g), b = static_cast<double>(value.b);
    if (setup_.beauty_ >= 0) {
        double* beauty = table_.raw_values(setup_.beauty_) + at;
        beauty[0] += r;
        beauty[1] += g;
        beauty[2] += b;
        table_.touch_in_passing(setup_.beauty_, tracker.row_);
    }
    if (path_strings_ != nullptr) [[unlikely]]
        keep_light(value, technique, tracker);
    const std::size_t words = tracker.groups_;
    const lpe::ProgramView& program = setup_.program_.view();
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        SampleTable::Light part{{0, r}, {g, b}};
        if (!tracker.whole_) {
            const BranchShare& share = tracker.share_[branch];
            part.first *= SampleTable::Pair{0, share.r};
            part.second *= SampleTable::Pair{share.g, share.b};
        }
        const lpe::State* const states = &tracker.state_[branch * words];
        for (std::uint32_t table = 0; table < program.table_count; ++table)
            for (const ChannelId target : targets_.of(states[table])) {
                if (target >= 0) {
                    double* values = table_.raw_values(target) + at;
                    values[0] += part.first[1];
                    values[1] += part.second[0];
                    values[2] += part.second[1];
                    table_.touch_in_passing(target, tracker.row_);
                } else {
                    table_.add_to_set(static_cast<std::size_t>(~target), tracker.row_, part);
                }
            }
        program.for_each_accepted_parallel(states, [&](std::uint16_t channel) {
            splat_slow_path({&setup_.channel_of_accept_[channel], 1},
                            RgbD(part.first[1], part.second[0], part.second[1]), tracker.row_);
        });
    }
}

inline bool LpeServices::live_after(const Tracker& tracker, lpe::EventClass event) const {
    if (takes_all(tracker)) return true;
    if (setup_.live_.empty() && tracker.held_out_) return false;
    const lpe::ProgramView& program = setup_.program_.view();
    std::array<lpe::State, Tracker::group_limit> next;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        if (!program.advance(&tracker.state_[branch * tracker.groups_], event, next.data())) continue;
        if (setup_.live_.empty() || is_live(next.data(), tracker.held_out_)) return true;
    }
    return false;
}

}  // namespace raylex::display
