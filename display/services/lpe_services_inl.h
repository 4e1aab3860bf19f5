// The hot half of the LPE services, for inlining into integrators. Include lpe_services.h instead.
#pragma once

#include "display/services/lpe_services.h"

#include <algorithm>
#include <cmath>

namespace raylex::display {

inline void Tracker::copy(const Tracker& other) noexcept {
    row_ = other.row_;
    moves_ = other.moves_;
    count_ = other.count_;
    groups_ = other.groups_;
    whole_ = other.whole_;
    const std::size_t states = std::size_t{count_} * groups_;
    for (std::size_t i = 0; i < states; ++i) state_[i] = other.state_[i];
    if (whole_) return;
    for (std::size_t i = 0; i < std::size_t{3} * count_; ++i) share_[i] = other.share_[i];
}

inline Tracker LpeServices::begin(int row) const {
    Tracker tracker;
    tracker.row_ = row;
    tracker.groups_ = static_cast<std::uint8_t>(setup_.first_states_.size());
    tracker.count_ = tracker.groups_ == 0 ? 0 : 1;
    for (std::size_t group = 0; group < tracker.groups_; ++group) tracker.state_[group] = setup_.first_states_[group];
    return tracker;
}

inline void LpeServices::move(Tracker& tracker, lpe::EventClass event) const {
    if (tracker.count_ == 0) return;
    ++tracker.moves_;
    const std::size_t groups = tracker.groups_;
    std::size_t kept = 0;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        const lpe::State* from = &tracker.state_[branch * groups];
        lpe::State* to = &tracker.state_[kept * groups];
        bool alive = false;
        for (std::size_t g = 0; g < groups; ++g) {
            to[g] = setup_.program_.next(from[g], event);
            alive = alive || to[g] != lpe::Program::dead;
        }
        if (!alive) continue;
        if (!tracker.whole_) {
            std::size_t at = 0;
            while (at < kept && !std::equal(to, to + groups, &tracker.state_[at * groups])) ++at;
            const bool merge = at < kept;
            for (std::size_t c = 0; c < 3; ++c) {
                const double share = tracker.share_[3 * branch + c];
                tracker.share_[3 * at + c] = merge ? tracker.share_[3 * at + c] + share : share;
            }
            if (merge) continue;
        }
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
    // Also true of NaN.
    const auto out_of_range = [](float v) { return !(std::abs(v) <= largest_contribution); };
    if (out_of_range(value.r) || out_of_range(value.g) || out_of_range(value.b)) {
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
    const std::size_t groups = tracker.groups_;
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        const double* share = &tracker.share_[3 * branch];
        const RgbD part = tracker.whole_ ? RgbD(r, g, b) : RgbD(r * share[0], g * share[1], b * share[2]);
        for (std::size_t group = 0; group < groups; ++group)
            for (const std::uint16_t channel : setup_.program_.accepted(tracker.state_[branch * groups + group])) {
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
    const std::size_t states = std::size_t{tracker.count_} * tracker.groups_;
    for (std::size_t i = 0; i < states; ++i)
        if (setup_.program_.next(tracker.state_[i], event) != lpe::Program::dead) return true;
    return false;
}

}  // namespace raylex::display
