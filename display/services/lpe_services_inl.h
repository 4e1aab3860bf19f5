// The hot half of the LPE services, for inlining into integrators. Include lpe_services.h instead.
#pragma once

#include "display/services/lpe_services.h"

namespace raylex::display {

inline void Tracker::copy(const Tracker& other) noexcept {
    row_ = other.row_;
    moves_ = other.moves_;
    count_ = other.count_;
    whole_ = other.whole_;
    for (std::size_t i = 0; i < count_; ++i) {
        state_[i] = other.state_[i];
        group_[i] = other.group_[i];
    }
    if (whole_) return;
    for (std::size_t i = 0; i < std::size_t{3} * count_; ++i) share_[i] = other.share_[i];
}

inline Tracker LpeServices::begin(int row) const {
    Tracker tracker;
    tracker.row_ = row;
    tracker.count_ = static_cast<std::uint8_t>(setup_.first_states_.size());
    for (std::size_t i = 0; i < tracker.count_; ++i) {
        tracker.state_[i] = setup_.first_states_[i];
        tracker.group_[i] = setup_.first_groups_[i];
    }
    return tracker;
}

inline void LpeServices::move(Tracker& tracker, lpe::EventClass event) const {
    if (tracker.count_ == 0) return;
    ++tracker.moves_;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tracker.count_; ++i) {
        const lpe::State next = setup_.program_.next(tracker.state_[i], event);
        if (next == lpe::Program::dead) continue;
        if (!tracker.whole_) {
            std::size_t at = 0;
            while (at < kept && tracker.state_[at] != next) ++at;
            const double* from = &tracker.share_[3 * i];
            double* to = &tracker.share_[3 * at];
            const bool merge = at < kept;
            for (int c = 0; c < 3; ++c) to[c] = merge ? to[c] + from[c] : from[c];
            if (merge) continue;
        }
        tracker.state_[kept] = next;
        tracker.group_[kept] = tracker.group_[i];
        ++kept;
    }
    tracker.count_ = static_cast<std::uint8_t>(kept);
}

inline void LpeServices::move(Tracker& tracker, std::span<const LobePart> parts) {
    if (tracker.count_ == 0) return;
    if (parts.size() == 1)
        move(tracker, parts[0].event);
    else
        split(tracker, parts);
}

inline void LpeServices::contribute(const Rgb& value, Technique technique, const Tracker& tracker) {
    if (value.is_black()) return;  // the common case of a light sample behind the surface
    if (!is_finite(value)) {
        reject(value, tracker);
        return;
    }
    ++contributions_[static_cast<std::size_t>(technique)];
    const std::size_t at = 3 * static_cast<std::size_t>(tracker.row_);
    const double r = static_cast<double>(value.r), g = static_cast<double>(value.g), b = static_cast<double>(value.b);
    if (setup_.beauty_ >= 0) {
        double* beauty = table_.values(setup_.beauty_) + at;
        beauty[0] += r;
        beauty[1] += g;
        beauty[2] += b;
        table_.touch(setup_.beauty_);
    }
    for (std::size_t i = 0; i < tracker.count_; ++i) {
        const std::span<const std::uint16_t> accepted = setup_.program_.accepted(tracker.state_[i]);
        if (accepted.empty()) continue;
        const double* share = &tracker.share_[3 * i];
        const RgbD part = tracker.whole_ ? RgbD(r, g, b) : RgbD(r * share[0], g * share[1], b * share[2]);
        for (const std::uint16_t channel : accepted) {
            const ChannelId id = setup_.channel_of_accept_[channel];
            double* values = table_.values(id) + at;
            values[0] += part.r;
            values[1] += part.g;
            values[2] += part.b;
            table_.touch(id);
        }
    }
}

inline bool LpeServices::live_after(const Tracker& tracker, lpe::EventClass event) const {
    if (setup_.beauty_ >= 0) return true;
    for (std::size_t i = 0; i < tracker.count_; ++i)
        if (setup_.program_.next(tracker.state_[i], event) != lpe::Program::dead) return true;
    return false;
}

}  // namespace raylex::display
