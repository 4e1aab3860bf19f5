#include "display/services/samples/lpe_services.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "display/services/parameters.h"
#include "display/services/samples/branches.h"
#include "display/services/split_mix.h"

namespace raylex::display {
namespace {

Status check_type(const ChannelDefinition& channel) {
    if (channel.type == ChannelType::rgb) return success();
    return error_at(location_of(channel), "channel '" + channel.name +
                                              "' has a light path expression but is not a colour; expected type rgb");
}

/// The expression channels among `channels` in the form that the compiler takes; `id_of` gets their display channels.
Result<std::vector<lpe::ChannelSource>> collect_sources(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                                        std::vector<ChannelId>& id_of) {
    std::vector<std::size_t> index_of(channels.size(), channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
        if (channels[i].style != ChannelStyle::expression || static_cast<ChannelId>(i) == beauty) continue;
        index_of[i] = id_of.size();
        id_of.push_back(static_cast<ChannelId>(i));
    }
    std::vector<lpe::ChannelSource> sources;
    for (const ChannelId id : id_of) {
        const ChannelDefinition& channel = channels[static_cast<std::size_t>(id)];
        lpe::ChannelSource source;
        source.name = channel.name;
        source.expression = channel.expression;
        source.dialect = channel.dialect;
        source.origin = location_of(channel).file;
        source.origin_line = channel.origin_line;
        source.origin_column = channel.origin_column;
        for (const std::size_t other : channel.rest_of) {
            if (other >= channels.size() || index_of[other] == channels.size())
                return error_at(location_of(channel), "channel '" + channel.name +
                                                          "' is the rest of a channel without a light path expression");
            source.rest_of.push_back(index_of[other]);
        }
        if (const Status status = check_type(channel); !status) return status.error();
        sources.push_back(std::move(source));
    }
    return sources;
}

}  // namespace

Result<LpeSetup> LpeSetup::build(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                 const lpe::CompileOptions& options) {
    LpeSetup setup;
    setup.of_class_ = options.first_alone;
    setup.find_main();
    setup.beauty_ = beauty;
    for (const ChannelDefinition& channel : channels)
        if (channel.style == ChannelStyle::expression)
            setup.largest_contribution_ = static_cast<float>(
                std::min(std::ldexp(0x1p38, channel.scale_exponent), double(std::numeric_limits<float>::max())));
    const Result<std::vector<lpe::ChannelSource>> sources = collect_sources(channels, beauty, setup.channel_of_accept_);
    if (!sources) return sources.error();
    if (sources->empty()) return setup;
    if (const Status status = setup.read_channel_prefixes(channels); !status) return status.error();
    lpe::CompileOptions limited = options;
    if (options.first_alone)
        limited.word_cap = std::min(options.word_cap, static_cast<std::size_t>(Tracker::layer_group_limit));
    Result<lpe::Program> program = lpe::Program::compile(*sources, limited);
    if (!program) return program.error();
    setup.program_ = std::move(*program);
    setup.find_main();
    const lpe::Program& compiled = setup.program_;
    if (compiled.group_count() > Tracker::group_limit)
        return error_at({},
                        "the light path expressions need " + std::to_string(compiled.group_count()) +
                            " words of state; expected at most " + std::to_string(Tracker::group_limit),
                        "request fewer channels whose expressions begin with `C.*`, or raise the state cap");
    setup.targets_ = SplatTargets(compiled.view(), setup.channel_of_accept_);
    std::vector<lpe::State>& first = setup.first_states_;
    first.resize(compiled.word_count());
    if (!compiled.advance(compiled.starts().data(), compiled.classify(lpe::Event{}), first.data())) first.clear();
    for (const lpe::ChannelSource& source : *sources)
        setup.has_user_events_ = setup.has_user_events_ || source.expression.find('U') != std::string::npos;
    setup.find_liveness();
    return setup;
}

void LpeSetup::find_main() {
    main_ = program_.view();
    if (of_class_ && main_.table_count > 0) main_.word_count = main_.table_count = 1;
}

LpeServices::LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed, Attribution attribution)
    : setup_(setup),
      table_(table),
      targets_(table.sets() != nullptr ? table.sets()->targets() : setup.targets_),
      seed_(seed),
      attribution_(attribution),
      path_strings_(setup.words() != nullptr ? &table.keep_path_strings(*setup.words()) : nullptr),
      slow_path_(setup.prefixed_),
      shares_(setup.prefixes_.size(), unused) {
    sharing_.reserve(setup.prefixes_.size());
}

/// Two moves of one path, and two directions from one vertex, get independent random numbers.
std::uint64_t LpeServices::random_key(const Tracker& tracker, const LobePart& first) const {
    const CameraRow& row = table_.camera_row(tracker.row_);
    std::uint64_t key = mix_bits(seed_ + golden_gamma);
    const auto absorb = [&key](std::uint64_t word) { key = mix_bits(key ^ word) + golden_gamma; };
    absorb((static_cast<std::uint64_t>(static_cast<std::uint32_t>(row.pixel_x)) << 32) |
           static_cast<std::uint32_t>(row.pixel_y));
    absorb(row.sample);
    absorb((static_cast<std::uint64_t>(tracker.moves_) << 32) | std::bit_cast<std::uint32_t>(first.value.r));
    absorb((static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(first.value.g)) << 32) |
           std::bit_cast<std::uint32_t>(first.value.b));
    return key;
}

std::size_t LpeServices::branch_limit(const Tracker& tracker) const {
    if (setup_.is_of_class()) return Tracker::class_capacity;
    return std::min<std::size_t>(Tracker::capacity, std::size_t{Tracker::state_room} / tracker.groups_);
}

void LpeServices::take(Tracker& tracker, const BranchList& branches) {
    tracker.whole_ = branches.whole;
    put(tracker.main(), branches);
}

void LpeServices::put(Tracker::List list, const BranchList& branches) {
    if (branches.overflow) ++overflow_count_;
    list.count = static_cast<std::uint8_t>(branches.count);
    const std::size_t states = branches.count * list.words;
    for (std::size_t i = 0; i < states; ++i) list.state[i] = branches.state[i];
    for (std::size_t i = 0; i < branches.count && !list.whole; ++i) list.share[i] = branches.share[i];
}

/// Moves branches with shares, and merges equal states.
void LpeServices::move_list(const lpe::ProgramView& program, Tracker::List list, lpe::EventClass event) {
    const std::size_t words = list.words, count = list.count;
    std::size_t kept = 0;
    for (std::size_t branch = 0; branch < count; ++branch) {
        lpe::State* to = &list.state[kept * words];
        if (words == 1) {
            to[0] = program.next(list.state[branch], event);
            if (to[0] == lpe::Program::dead) continue;
        } else if (!program.advance(&list.state[branch * words], event, to)) {
            continue;
        }
        std::size_t at = 0;
        while (at < kept && !std::equal(to, to + words, &list.state[at * words])) ++at;
        const bool merge = at < kept;
        const BranchShare share = list.share[branch];
        BranchShare& sum = list.share[at];
        sum = merge ? BranchShare{sum.r + share.r, sum.g + share.g, sum.b + share.b} : share;
        if (!merge) ++kept;
    }
    list.count = static_cast<std::uint8_t>(kept);
}

/// Moves a tracker that is not whole.
void LpeServices::move_split(Tracker& tracker, lpe::EventClass event) const {
    move_list(setup_.main_, tracker.main(), event);
    if (tracker.count_ == 0) tracker.layer_count_ = 0;
    if (tracker.layer_count_ != 0) move_list(setup_.program_.view(), tracker.layers(), event);
}

/// Splits branch by branch, and merges equal states at once.
void LpeServices::split(Tracker& tracker, std::span<const LobePart> parts) {
    if (parts.empty()) {
        tracker.count_ = tracker.layer_count_ = 0;
        return;
    }
    ++tracker.moves_;
    ChoiceNumbers numbers([&] { return random_key(tracker, parts[0]); });
    Fractions fractions(parts);
    if (attribution_ == Attribution::picked) fractions.pick(numbers.next());
    const lpe::ProgramView& program = setup_.main_;
    if (tracker.whole_ && setup_.has_layers()) tracker.divide();
    BranchList branches(tracker.groups_);
    branches.split(tracker.branches_of_main(), parts, fractions, branch_limit(tracker), numbers,
                   [&](const lpe::State* from, lpe::EventClass event, lpe::State* to) {
                       return program.advance(from, event, to);
                   });
    take(tracker, branches);
    if (tracker.layer_count_ != 0) split_layers(tracker, parts, fractions, tracker.branches_of_main());
}

/// Splats to packed channels, and to other channels of a set without a column in the table.
void LpeServices::splat_slow_path(std::span<const ChannelId> channels, const RgbD& value, int row) {
    for (const ChannelId id : channels) {
        double* to = table_.raw_values(id) + 3 * static_cast<std::size_t>(row);
        for (int c = 0; c < 3; ++c) to[c] += value[c];
        table_.touch(id, row);
    }
}

/// Counts one rejection for the camera ray, and one for beauty and each channel that would have taken a part.
void LpeServices::reject(const Rgb& value, const Tracker& tracker) {
    ++invalid_count_;
    table_.count_invalid(tracker.row_, invalid_channel, value);
    if (takes_all(tracker)) table_.count_invalid_of(setup_.beauty_);
    std::vector<std::uint16_t> counted;  // few of these calls are made, so they may allocate
    for_each_accepted(tracker, [&](std::uint16_t channel, const RgbD&) {
        const ChannelPrefixes& prefixes = setup_.prefixes_[channel];
        if (prefixes.holdouts != tracker.held_out_) return;
        if (prefixes.own_value() && prefixes.noinfinitecheck) return;  // its own value decides
        if (std::find(counted.begin(), counted.end(), channel) != counted.end()) return;
        counted.push_back(channel);
        table_.count_invalid_of(setup_.channel_of_accept_[channel]);
    });
}

}  // namespace raylex::display
