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
            return error_at(location_of(channel), found +
                                                      ", which would let non-finite values into an image; expected "
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
                return error_at(
                    location_of(channel),
                    "channel '" + channel.name + "' is the rest of a channel that has no light path expression");
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
    std::array<std::size_t, 3> picked_{};  // part 0 for a colour to which nothing is given
    std::array<bool, 3> proportional_{};
};

}  // namespace

/// The branches of a tracker in the middle of a move, equal states merged.
struct LpeServices::BranchList {
    static constexpr std::size_t room = 96;
    std::size_t count = 0;
    std::size_t groups;
    std::array<lpe::State, room * Tracker::group_limit> state;
    std::array<double, 3 * room> share;

    explicit BranchList(std::size_t group_count) : groups(group_count) {}  // leaves the arrays uninitialised

    [[nodiscard]] bool full() const { return count == room; }
    /// Where the states of one more branch go; add() makes it one.
    lpe::State* next_states() { return &state[count * groups]; }
    /// Adds the branch whose states were put into next_states(), unless they are all dead.
    void add(const double* amount) {
        const lpe::State* fresh = next_states();
        if (std::all_of(fresh, fresh + groups, [](lpe::State s) { return s == lpe::Program::dead; })) return;
        std::size_t at = 0;
        while (at < count && !std::equal(fresh, fresh + groups, &state[at * groups])) ++at;
        if (at == count) {
            std::copy_n(amount, 3, &share[3 * at]);
            ++count;
            return;
        }
        for (std::size_t c = 0; c < 3; ++c) share[3 * at + c] += amount[c];
    }
    [[nodiscard]] double size(std::size_t i) const { return share[3 * i] + share[3 * i + 1] + share[3 * i + 2]; }
    /// Drops branches whose shares are all 0.
    void compact() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (size(i) == 0) continue;
            std::copy_n(&state[i * groups], groups, &state[kept * groups]);
            std::copy_n(&share[3 * i], 3, &share[3 * kept]);
            ++kept;
        }
        count = kept;
    }
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
    const lpe::Program& compiled = setup.program_;
    if (compiled.group_count() > Tracker::group_limit)
        return error_at({},
                        "the light path expressions need " + std::to_string(compiled.group_count()) +
                            " automaton groups; expected at most " + std::to_string(Tracker::group_limit),
                        "ask for fewer channels whose expressions begin with `C.*`, or raise the state cap");
    const lpe::EventClass camera = compiled.classify(lpe::Event{});
    for (const lpe::State start : compiled.starts()) setup.first_states_.push_back(compiled.next(start, camera));
    if (std::count(setup.first_states_.begin(), setup.first_states_.end(), lpe::Program::dead) ==
        static_cast<std::ptrdiff_t>(setup.first_states_.size()))
        setup.first_states_.clear();
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

    const std::size_t groups = tracker.groups_;
    const std::size_t target = std::min<std::size_t>(Tracker::capacity, Tracker::state_room / groups);
    BranchList branches(groups);
    bool whole = tracker.whole_, overflow = false;
    const auto shrink = [&] {
        require_key();
        collapse(branches, target, random_state);
        overflow = true;
    };
    const auto step = [&](std::size_t branch, const LobePart& part) {
        const lpe::State* from = &tracker.state_[branch * groups];
        std::transform(from, from + groups, branches.next_states(),
                       [&](lpe::State state) { return setup_.program_.next(state, part.event); });
    };
    const auto agrees = [&](std::size_t branch, const LobePart& part) {
        const lpe::State* from = &tracker.state_[branch * groups];
        return std::equal(from, from + groups, branches.next_states(), [&](lpe::State state, lpe::State next) {
            return setup_.program_.next(state, part.event) == next;
        });
    };
    constexpr std::array<double, 3> one{1.0, 1.0, 1.0};
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        if (branches.full()) shrink();
        const double* base = tracker.whole_ ? one.data() : &tracker.share_[3 * branch];
        step(branch, parts[0]);
        if (std::all_of(parts.begin() + 1, parts.end(), [&](const LobePart& part) { return agrees(branch, part); })) {
            branches.add(base);  // the parts' fractions sum to 1: nothing is split, nothing is rounded
            continue;
        }
        whole = false;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const std::array<double, 3> share{base[0] * fractions.of(j, 0), base[1] * fractions.of(j, 1),
                                              base[2] * fractions.of(j, 2)};
            if (share[0] == 0 && share[1] == 0 && share[2] == 0) continue;
            if (branches.full()) shrink();
            step(branch, parts[j]);
            branches.add(share.data());
        }
    }
    if (branches.count > target) shrink();
    if (overflow) ++overflow_count_;

    tracker.whole_ = whole;
    tracker.count_ = static_cast<std::uint8_t>(branches.count);
    std::copy_n(branches.state.begin(), branches.count * groups, tracker.state_.begin());
    if (!whole) std::copy_n(branches.share.begin(), 3 * branches.count, tracker.share_.begin());
}

/// Brings `branches` down to `target` by collapsing the smallest. The collapse moves, per colour, all that the chosen
/// branches hold to one of them, drawn in proportion to what it held: the sum is kept exactly and each branch's
/// expected share is what it was. One random number serves the three colours, so that they mostly agree on the
/// survivor; at most three survive, so three more than the excess are chosen.
void LpeServices::collapse(BranchList& branches, std::size_t target, std::uint64_t& random_state) {
    const std::size_t chosen_count = branches.count - target + 3;
    std::array<std::uint16_t, BranchList::room> order;
    std::iota(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(branches.count), std::uint16_t{0});
    std::array<double, BranchList::room> size;
    for (std::size_t i = 0; i < branches.count; ++i) size[i] = branches.size(i);
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(chosen_count),
                      order.begin() + static_cast<std::ptrdiff_t>(branches.count),
                      [&](std::uint16_t a, std::uint16_t b) { return size[a] != size[b] ? size[a] < size[b] : a < b; });
    const double random = next_random(random_state);
    for (std::size_t c = 0; c < 3; ++c) {
        double total = 0, below = 0;
        for (std::size_t k = 0; k < chosen_count; ++k) total += branches.share[3u * order[k] + c];
        std::size_t survivor = order[0];
        bool found = false;
        for (std::size_t k = 0; k < chosen_count; ++k) {
            double& share = branches.share[3u * order[k] + c];
            if (!found && share > 0) survivor = order[k];
            below += share;
            found = found || random * total < below;
            share = 0;
        }
        branches.share[3 * survivor + c] = total;
    }
    branches.compact();
}

void LpeServices::reject(const Rgb& value, const Tracker& tracker) {
    ++invalid_count_;
    if (invalid_samples_.size() == invalid_samples_kept) return;
    const CameraRow& row = table_.camera_row(tracker.row_);
    invalid_samples_.push_back({row.pixel_x, row.pixel_y, row.sample, value});
}

}  // namespace raylex::display
