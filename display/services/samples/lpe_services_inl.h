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
    layer_count_ = other.layer_count_;
    layer_groups_ = other.layer_groups_;
    const std::size_t states = std::size_t{count_} * groups_;
    for (std::size_t i = 0; i < states; ++i) state_[i] = other.state_[i];
    if (whole_) return;
    for (std::size_t i = 0; i < count_; ++i) share_[i] = other.share_[i];
    if (layer_count_ != 0) [[unlikely]]
        copy_layers(other);
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
    if (!tracker.whole_) return move_split(tracker, event);
    if (tracker.groups_ == 1) {
        tracker.state_[0] = program.next(tracker.state_[0], event);
        tracker.count_ = tracker.state_[0] != lpe::Program::dead;
    } else {
        tracker.count_ = program.advance(tracker.state_.data(), event, tracker.state_.data());
    }
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
    const SampleTable::Light light{{0, r}, {g, b}};
    if (tracker.whole_) {
        if (tracker.count_ != 0) splat_branch(setup_.program_.view(), tracker.state_.data(), 0, light, tracker.row_);
        return;
    }
    const auto splat_list = [&](const lpe::ProgramView& program, const Branches& list, std::uint32_t first_table) {
        for (std::size_t branch = 0; branch < list.count; ++branch) {
            SampleTable::Light part = light;
            part.first *= SampleTable::Pair{0, list.share[branch].r};
            part.second *= SampleTable::Pair{list.share[branch].g, list.share[branch].b};
            splat_branch(program, list.state_of(branch), first_table, part, tracker.row_);
        }
    };
    splat_list(setup_.main_, tracker.branches_of_main(), 0);
    if (tracker.layer_count_ != 0) splat_list(setup_.program_.view(), tracker.branches_of_layers(), 1);
}

inline void LpeServices::splat_branch(const lpe::ProgramView& program, const lpe::State* states,
                                      std::uint32_t first_table, const SampleTable::Light& part, int row) {
    const std::size_t at = 3 * static_cast<std::size_t>(row);
    for (std::uint32_t table = first_table; table < program.table_count; ++table)
        for (const ChannelId target : targets_.of(states[table])) {
            if (target >= 0) {
                double* values = table_.raw_values(target) + at;
                values[0] += part.first[1];
                values[1] += part.second[0];
                values[2] += part.second[1];
                table_.touch_in_passing(target, row);
            } else {
                table_.add_to_set(static_cast<std::size_t>(~target), row, part);
            }
        }
    program.for_each_accepted_parallel(states, [&](std::uint16_t channel) {
        splat_slow_path({&setup_.channel_of_accept_[channel], 1}, RgbD(part.first[1], part.second[0], part.second[1]),
                        row);
    });
}

template <class Visit>
void LpeServices::for_each_accepted(const Tracker& tracker, Visit visit) const {
    const auto visit_list = [&](const lpe::ProgramView& program, const Branches& list, bool beside_class) {
        for (std::size_t branch = 0; branch < list.count; ++branch)
            program.for_each_accepted(list.state_of(branch), [&](std::uint16_t channel) {
                if (!beside_class || channel != 0) visit(channel, list.share_of(branch));
            });
    };
    if (tracker.whole_) return visit_list(setup_.program_.view(), tracker.branches_of_main(), false);
    visit_list(setup_.main_, tracker.branches_of_main(), false);
    visit_list(setup_.program_.view(), tracker.branches_of_layers(), true);
}

inline bool LpeServices::live_after(const Tracker& tracker, lpe::EventClass event) const {
    if (takes_all(tracker)) return true;
    Tracker ahead = tracker;
    move_states(ahead, event);
    return live(ahead);
}

}  // namespace raylex::display
