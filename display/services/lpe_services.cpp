#include "display/services/lpe_services.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <string>
#include <utility>

#include "display/services/parameters.h"
#include "lpe/check.h"

namespace raylex::display {
namespace {

SourceLocation location_of(const ChannelDefinition& channel) {
    return {channel.origin.empty() ? "channel '" + channel.name + "'" : channel.origin, channel.origin_line,
            channel.origin_column};
}

/// Refuses what no part of this renderer would honour.
Status check_channel(const ChannelDefinition& channel, const lpe::ChannelSource& source) {
    if (channel.type != ChannelType::rgb)
        return error_at(location_of(channel), "channel '" + channel.name +
                                                  "' has a light path expression but is no colour; expected type rgb");
    if (!channel.rest_of.empty()) return success();
    const Result<std::vector<std::string>> prefixes = lpe::expression_prefixes(source);
    if (!prefixes) return prefixes.error();
    for (const std::string& prefix : *prefixes) {
        if (prefix == "noclamp") continue;
        const std::string found = "channel '" + channel.name + "' has the prefix '" + prefix + ";'";
        if (prefix == "noinfinitecheck")
            return error_at(location_of(channel), found + ", which would let non-finite values into an image; expected "
                                                          "an expression without it");
        return error_at(location_of(channel),
                        found + ", which this version does not honour; expected no prefix, or 'noclamp;'");
    }
    return success();
}

/// The expression channels among `channels` as the compiler takes them; `id_of` gets their display channels.
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
                                                          "' is the rest of a channel that has no light path expression");
            source.rest_of.push_back(index_of[other]);
        }
        if (const Status status = check_channel(channel, source); !status) return status.error();
        sources.push_back(std::move(source));
    }
    return sources;
}

/// Finaliser of SplitMix64 (S. Vigna, public domain description): a bijection that mixes every bit.
std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

double next_random(std::uint64_t& state) {
    state += 0x9e3779b97f4a7c15ull;
    return static_cast<double>(mix(state) >> 11) * 0x1p-53;
}

/// What fraction of a scattering each part carries, per colour: proportional, or all to one drawn part.
class Fractions {
  public:
    explicit Fractions(std::span<const LobePart> parts) : parts_(parts) {
        for (const LobePart& part : parts) total_ += RgbD(part.value);
        for (int c = 0; c < 3; ++c) proportional_[c] = total_[c] > 0 && std::isfinite(total_[c]);
    }
    /// Draws one part per colour, in proportion to what it carries, by the same number for every colour.
    void pick(double random) {
        for (int c = 0; c < 3; ++c) {
            if (!proportional_[c]) continue;
            double below = 0;
            for (std::size_t j = 0; j < parts_.size(); ++j) {
                const double value = static_cast<double>(parts_[j].value[c]);
                if (value <= 0) continue;
                picked_[c] = j;  // the last part with a value, should rounding leave the sum below the target
                below += value;
                if (random * total_[c] < below) break;
            }
            proportional_[c] = false;
        }
    }
    [[nodiscard]] double of(std::size_t part, int c) const {
        if (proportional_[c]) return static_cast<double>(parts_[part].value[c]) / total_[c];
        return part == picked_[c] ? 1.0 : 0.0;
    }

  private:
    std::span<const LobePart> parts_;
    RgbD total_;
    std::array<std::size_t, 3> picked_{};       // part 0 for a colour to which nothing is given
    std::array<bool, 3> proportional_{};
};

}  // namespace

/// The pairs of a tracker in the middle of a move, equal states merged.
struct LpeServices::PairList {
    static constexpr std::size_t room = 128;
    std::size_t count = 0;
    std::array<lpe::State, room> state;
    std::array<std::uint8_t, room> group;
    std::array<double, 3 * room> share;

    PairList() {}  // leaves the arrays uninitialised
    void add(lpe::State s, std::uint8_t g, const double* amount) {
        std::size_t at = 0;
        while (at < count && state[at] != s) ++at;
        if (at == count) {
            state[at] = s;
            group[at] = g;
            std::copy_n(amount, 3, &share[3 * at]);
            ++count;
            return;
        }
        for (std::size_t c = 0; c < 3; ++c) share[3 * at + c] += amount[c];
    }
    [[nodiscard]] double size(std::size_t i) const { return share[3 * i] + share[3 * i + 1] + share[3 * i + 2]; }
};

Result<LpeSetup> LpeSetup::build(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                 const lpe::CompileOptions& options) {
    LpeSetup setup;
    setup.beauty_ = beauty;
    const Result<std::vector<lpe::ChannelSource>> sources = collect_sources(channels, beauty, setup.channel_of_accept_);
    if (!sources) return sources.error();
    if (sources->empty()) return setup;
    Result<lpe::Program> program = lpe::Program::compile(*sources, options);
    if (!program) return program.error();
    setup.program_ = std::move(*program);
    constexpr std::size_t group_limit = Tracker::capacity / 3;
    if (setup.program_.group_count() > group_limit)
        return Error{"the light path expressions need " + std::to_string(setup.program_.group_count()) +
                         " automaton groups; expected at most " + std::to_string(group_limit),
                     "", 0, 0, "", "ask for fewer channels whose expressions begin with `C.*`, or raise the state cap"};
    const lpe::EventClass camera = setup.program_.classify(lpe::Event{});
    for (std::size_t group = 0; group < setup.program_.group_count(); ++group) {
        const lpe::State state = setup.program_.next(setup.program_.starts()[group], camera);
        if (state == lpe::Program::dead) continue;
        setup.first_states_.push_back(state);
        setup.first_groups_.push_back(static_cast<std::uint8_t>(group));
    }
    return setup;
}

LpeServices::LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed, Attribution attribution)
    : setup_(setup), table_(table), seed_(seed), attribution_(attribution) {
    invalid_samples_.reserve(invalid_samples_kept);
}

/// Two moves of one path, and two directions tried at one vertex, draw independent numbers.
std::uint64_t LpeServices::random_key(const Tracker& tracker, const LobePart& first) const {
    const CameraRow& row = table_.camera_row(tracker.row_);
    std::uint64_t key = mix(seed_ + 0x9e3779b97f4a7c15ull);
    const auto absorb = [&key](std::uint64_t word) { key = mix(key ^ word) + 0x9e3779b97f4a7c15ull; };
    absorb((static_cast<std::uint64_t>(static_cast<std::uint32_t>(row.pixel_x)) << 32) |
           static_cast<std::uint32_t>(row.pixel_y));
    absorb(row.sample);
    absorb((static_cast<std::uint64_t>(tracker.moves_) << 32) | std::bit_cast<std::uint32_t>(first.value.r));
    absorb((static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(first.value.g)) << 32) |
           std::bit_cast<std::uint32_t>(first.value.b));
    return key;
}

void LpeServices::split(Tracker& tracker, std::span<const LobePart> parts) {
    if (parts.empty()) {
        tracker.count_ = 0;
        return;
    }
    ++tracker.moves_;
    Fractions fractions(parts);
    std::uint64_t random_state = 0;
    bool has_key = false;
    const auto require_key = [&] {
        if (!has_key) random_state = random_key(tracker, parts[0]);
        has_key = true;
    };
    if (attribution_ == Attribution::picked) {
        require_key();
        fractions.pick(next_random(random_state));
    }

    PairList pairs;
    bool whole = tracker.whole_, overflow = false;
    const auto shrink = [&] {
        require_key();
        collapse(pairs, Tracker::capacity, random_state);
        overflow = true;
    };
    constexpr std::array<double, 3> one{1.0, 1.0, 1.0};
    for (std::size_t i = 0; i < tracker.count_; ++i) {
        const double* base = tracker.whole_ ? one.data() : &tracker.share_[3 * i];
        const lpe::State first = setup_.program_.next(tracker.state_[i], parts[0].event);
        const bool together = std::all_of(parts.begin() + 1, parts.end(), [&](const LobePart& part) {
            return setup_.program_.next(tracker.state_[i], part.event) == first;
        });
        if (together) {  // the parts' fractions sum to 1: nothing is split, nothing is rounded
            if (pairs.count == PairList::room) shrink();
            if (first != lpe::Program::dead) pairs.add(first, tracker.group_[i], base);
            continue;
        }
        whole = false;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const lpe::State next = setup_.program_.next(tracker.state_[i], parts[j].event);
            if (next == lpe::Program::dead) continue;
            const std::array<double, 3> share{base[0] * fractions.of(j, 0), base[1] * fractions.of(j, 1),
                                              base[2] * fractions.of(j, 2)};
            if (share[0] == 0 && share[1] == 0 && share[2] == 0) continue;
            if (pairs.count == PairList::room) shrink();
            pairs.add(next, tracker.group_[i], share.data());
        }
    }
    if (pairs.count > Tracker::capacity) shrink();
    if (overflow) ++overflow_count_;

    tracker.whole_ = whole;
    tracker.count_ = static_cast<std::uint8_t>(pairs.count);
    std::copy_n(pairs.state.begin(), pairs.count, tracker.state_.begin());
    std::copy_n(pairs.group.begin(), pairs.count, tracker.group_.begin());
    if (!whole) std::copy_n(pairs.share.begin(), 3 * pairs.count, tracker.share_.begin());
}

/// Brings `pairs` down to `target` by collapsing the smallest of the largest group, again and again. Each collapse moves,
/// per colour, all that the chosen pairs hold to one of them, drawn in proportion to what it held: the sum is kept
/// exactly and each pair's expected share is what it was. One random number serves the three colours, so that they
/// mostly agree on the survivor; at most three survive. With groups <= target / 3 some group always has more than three.
void LpeServices::collapse(PairList& pairs, std::size_t target, std::uint64_t& random_state) const {
    while (pairs.count > target) {
        std::array<std::size_t, Tracker::capacity> members{};  // [group]
        for (std::size_t i = 0; i < pairs.count; ++i) ++members[pairs.group[i]];
        const auto group = static_cast<std::size_t>(std::max_element(members.begin(), members.end()) - members.begin());

        std::array<std::size_t, PairList::room> chosen;
        std::size_t chosen_count = 0;
        for (std::size_t i = 0; i < pairs.count; ++i)
            if (pairs.group[i] == group) chosen[chosen_count++] = i;
        std::sort(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(chosen_count),
                  [&](std::size_t a, std::size_t b) {
                      const double size_a = pairs.size(a), size_b = pairs.size(b);
                      return size_a != size_b ? size_a < size_b : pairs.state[a] < pairs.state[b];
                  });
        chosen_count = std::min(chosen_count, pairs.count - target + 3);

        const double random = next_random(random_state);
        for (std::size_t c = 0; c < 3; ++c) {
            double total = 0, below = 0;
            for (std::size_t k = 0; k < chosen_count; ++k) total += pairs.share[3 * chosen[k] + c];
            std::size_t survivor = chosen[0];
            bool found = false;
            for (std::size_t k = 0; k < chosen_count; ++k) {
                double& share = pairs.share[3 * chosen[k] + c];
                if (!found && share > 0) survivor = chosen[k];
                below += share;
                found = found || random * total < below;
                share = 0;
            }
            pairs.share[3 * survivor + c] = total;
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < pairs.count; ++i) {
            if (pairs.size(i) == 0) continue;
            pairs.state[kept] = pairs.state[i];
            pairs.group[kept] = pairs.group[i];
            for (std::size_t c = 0; c < 3; ++c) pairs.share[3 * kept + c] = pairs.share[3 * i + c];
            ++kept;
        }
        pairs.count = kept;
    }
}

void LpeServices::reject(const Rgb& value, const Tracker& tracker) {
    ++invalid_count_;
    if (invalid_samples_.size() == invalid_samples_kept) return;
    const CameraRow& row = table_.camera_row(tracker.row_);
    invalid_samples_.push_back({row.pixel_x, row.pixel_y, row.sample, value});
}

}  // namespace raylex::display
