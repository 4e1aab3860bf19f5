// The slow path of a contribution, for prefixes and holdouts. Renders without either never use it.
#include <algorithm>
#include <utility>

#include "display/services/samples/lpe_services.h"

namespace raylex::display {

/// One event as an argument of contribute_slow_path().
struct LpeServices::Report {
    Rgb value;  ///< the value that beauty takes
    EmitterSample sample;
    const Technique* technique;  ///< null: a surface's own event, which beauty never takes
};

namespace {

/// The value that a channel with these prefixes takes of the event; black for nothing.
Rgb own_value(const ChannelPrefixes& prefixes, const Rgb& value, const EmitterSample& sample,
              const Technique* technique) {
    if (!prefixes.takes(technique)) return Rgb();
    if (prefixes.unweighted) return sample.unweighted * sample.visibility;
    if (prefixes.light_samples()) {
        if (sample.sampled_too) return Rgb();
        const Rgb& whole = prefixes.nothruput ? sample.emitted : sample.unweighted;
        return prefixes.unoccluded ? whole : whole * (1 - sample.visibility);
    }
    return prefixes.nothruput ? sample.emitted * sample.visibility : value;
}

}  // namespace

Status LpeSetup::read_channel_prefixes(std::span<const ChannelDefinition> channels) {
    for (const ChannelId id : channel_of_accept_) {
        const Result<ChannelPrefixes> read = read_prefixes(channels[static_cast<std::size_t>(id)]);
        if (!read) return read.error();
        prefixes_.push_back(*read);
        prefixed_ = prefixed_ || read->own_value() || read->holdouts;
        wants_emitter_samples_ = wants_emitter_samples_ || read->emitter_sample() || read->unweighted;
        if (read->emitter_sample() && needs_emitter_samples_ < 0) needs_emitter_samples_ = id;
        if (read->light_samples() && needs_light_samples_ < 0) needs_light_samples_ = id;
    }
    return success();
}

bool LpeSetup::follows(lpe::EventClass event) const {
    return has_user_events_ && program_.follows(event);
}

/// With `holdouts` channels a state that is not dead may still be of no use to a path, which is either held out or not.
/// Bit-parallel channels are taken together: where the path may still end so that one of them accepts, all are live.
/// That may keep a path that is of no use, and never ends one that is.
void LpeSetup::find_liveness() {
    if (std::none_of(prefixes_.begin(), prefixes_.end(), [](const ChannelPrefixes& p) { return p.holdouts; })) return;
    const lpe::ProgramView& program = program_.view();
    lpe::StateSets accepting(program.state_count);
    for (lpe::State state = 0; state < program.state_count; ++state)
        for (const std::uint16_t channel : program.accepted(state)) accepting[state] |= taker(channel);
    const std::size_t lists = program.widths.back().lists;  // of one terminal
    for (lpe::State state = program.first_ended; program.has_parallel() && state < program.state_count; ++state) {
        const std::uint32_t* list = program.parallel_lists + (state - program.first_ended) * lists;
        for (std::uint32_t i = list[0]; i < list[lists]; ++i) accepting[state] |= taker(program.accept_lists[i]);
    }
    const lpe::LivenessTable table(program.state_count,
                                   [&](lpe::State from, lpe::EventClass event) { return program.next(from, event); });
    live_ = table.eventually(lpe::all_classes(program.class_count), std::move(accepting));
}

bool LpeServices::is_live(const Tracker& tracker) const {
    const auto any = [&](const lpe::ProgramView& program, const Branches& list) {
        for (std::size_t branch = 0; branch < list.count; ++branch)
            if (is_live(program, list.state_of(branch), tracker.held_out_)) return true;
        return false;
    };
    const lpe::ProgramView& program = setup_.program_.view();
    if (tracker.whole_) return any(program, tracker.branches_of_main());
    // Beside a class only channels of held out paths have a liveness of their own.
    return any(setup_.main_, tracker.branches_of_main()) ||
           (tracker.held_out_ && any(program, tracker.branches_of_layers()));
}

bool LpeServices::needs_visibility(const Tracker& tracker) const {
    if (takes_all(tracker)) return true;
    bool needed = false;
    for_each_accepted(tracker, [&](std::uint16_t channel, const RgbD&) {
        const ChannelPrefixes& prefixes = setup_.prefixes_[channel];
        needed = needed || (prefixes.holdouts == tracker.held_out_ && !prefixes.unoccluded);
    });
    return needed;
}

void LpeServices::hold_out(Tracker& tracker) {
    tracker.held_out_ = true;
    slow_path_ = true;
}

void LpeServices::contribute(const Rgb& value, Technique technique, const Tracker& tracker,
                             const EmitterSample& sample) {
    contribute_slow_path({value, sample, &technique}, tracker);
}

void LpeServices::contribute_user(const Rgb& value, const Rgb& throughput, const Tracker& tracker) {
    const Rgb through = value * throughput;
    contribute_slow_path({through, {value, through, 1, false}, nullptr}, tracker);
}

void LpeServices::contribute_slow_path(const Report& report, const Tracker& tracker) {
    const Rgb& value = report.value;
    const bool valid = !out_of_range(value, setup_.largest_contribution_), black = value.is_black();
    if (!valid) reject(value, tracker);
    const std::size_t at = 3 * static_cast<std::size_t>(tracker.row_);
    const RgbD whole(value);
    const auto splat = [&](ChannelId id, const RgbD& part) {
        double* values = table_.raw_values(id) + at;
        values[0] += part.r;
        values[1] += part.g;
        values[2] += part.b;
        table_.touch(id, tracker.row_);
    };
    if (valid && !black && report.technique != nullptr && takes_all(tracker)) {
        splat(setup_.beauty_, whole);
        if (path_strings_ != nullptr) keep_light(value, *report.technique, tracker);
    }
    for_each_accepted(tracker, [&](std::uint16_t channel, const RgbD& share) {
        const ChannelPrefixes& prefixes = setup_.prefixes_[channel];
        if (prefixes.holdouts != tracker.held_out_) return;
        if (!prefixes.own_value()) {
            if (valid && !black) splat(setup_.channel_of_accept_[channel], whole * share);
            return;
        }
        if (shares_[channel] == unused) {
            sharing_.push_back(channel);
            shares_[channel] = RgbD();
        }
        shares_[channel] += share;
    });
    if (sharing_.empty()) return;
    splat_slow_path(report, tracker, valid);
    for (const std::uint16_t channel : sharing_) shares_[channel] = unused;
    sharing_.clear();
}

/// Splats to the channels of sharing_, each with its own value. A value that is out of range counts as one rejected
/// contribution for all channels together, unless beauty's was already rejected.
void LpeServices::splat_slow_path(const Report& report, const Tracker& tracker, bool valid) {
    bool rejected = !valid;
    for (const std::uint16_t channel : sharing_) {
        const ChannelPrefixes& prefixes = setup_.prefixes_[channel];
        if (!valid && !prefixes.noinfinitecheck) continue;
        const Rgb own = own_value(prefixes, report.value, report.sample, report.technique);
        if (own.is_black()) continue;
        const ChannelId id = setup_.channel_of_accept_[channel];
        if (out_of_range(own, setup_.largest_contribution_)) {
            if (std::exchange(rejected, true)) {
                table_.count_invalid_of(id);
            } else {
                ++invalid_count_;
                table_.count_invalid(tracker.row_, id, own);
            }
            continue;
        }
        double* values = table_.raw_values(id) + 3 * static_cast<std::size_t>(tracker.row_);
        const RgbD part = RgbD(own) * shares_[channel];
        for (int c = 0; c < 3; ++c) values[c] = prefixes.overwrite ? part[c] : values[c] + part[c];
        table_.touch(id, tracker.row_);
    }
}

}  // namespace raylex::display
