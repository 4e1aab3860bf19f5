#include "display/services/lpe_services.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "display/services/parameters.h"

namespace raylex::display {
namespace {

Status check_type(const ChannelDefinition& channel) {
    if (channel.type == ChannelType::rgb) return success();
    return error_at(location_of(channel), "channel '" + channel.name +
                                              "' has a light path expression but is no colour; expected type rgb");
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
        if (const Status status = check_type(channel); !status) return status.error();
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
        for (int c = 0; c < 3; ++c) {
            proportional_[c] = total_[c] > 0 && std::isfinite(total_[c]);
            scale_[c] = 1 / total_[c];  // of floats: never beyond the range of double where it is used
        }
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
    [[nodiscard]] RgbD of(std::size_t part) const {
        RgbD fraction;
        for (int c = 0; c < 3; ++c)
            fraction[c] = proportional_[c] ? static_cast<double>(parts_[part].value[c]) * scale_[c]
                                           : (part == picked_[c] ? 1.0 : 0.0);
        return fraction;
    }

  private:
    std::span<const LobePart> parts_;
    RgbD total_, scale_;
    std::array<std::size_t, 3> picked_{};  // part 0 for a colour to which nothing is given
    std::array<bool, 3> proportional_{};
};

}  // namespace

/// The branches of a tracker in the middle of a move, equal states merged.
struct LpeServices::BranchList {
    static constexpr std::size_t room = 96;
    std::size_t count = 0;
    std::size_t words;   // of a state
    std::array<lpe::State, room * Tracker::group_limit> state;
    std::array<Tracker::Share, room> share;

    explicit BranchList(std::size_t state_words) : words(state_words) {}  // leaves the arrays uninitialised

    [[nodiscard]] bool has_room_for(std::size_t more) const { return count + more <= room; }
    /// Where candidates for further branches are written, side by side.
    [[nodiscard]] lpe::State* candidates() { return &state[count * words]; }
    [[nodiscard]] static bool same(const lpe::State* a, const lpe::State* b, std::size_t words) {
        for (std::size_t i = 0; i < words; ++i)
            if (a[i] != b[i]) return false;
        return true;
    }
    /// Makes a candidate a branch. It and those behind it stay where they are: branches take no more room than candidates.
    void add(const lpe::State* candidate, const RgbD& amount) {
        std::size_t at = 0;
        while (at < count && !same(candidate, &state[at * words], words)) ++at;
        if (at < count) {
            share[at] = {share[at].r + amount.r, share[at].g + amount.g, share[at].b + amount.b};
            return;
        }
        for (std::size_t i = 0; i < words; ++i) state[at * words + i] = candidate[i];
        share[at] = {amount.r, amount.g, amount.b};
        ++count;
    }
    [[nodiscard]] double size(std::size_t i) const { return share[i].r + share[i].g + share[i].b; }
    /// Drops branches whose shares are all 0.
    void compact() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (size(i) == 0) continue;
            std::copy_n(&state[i * words], words, &state[kept * words]);
            share[kept++] = share[i];
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
    if (const Status status = setup.read_channel_prefixes(channels); !status) return status.error();
    Result<lpe::Program> program = lpe::Program::compile(*sources, options);
    if (!program) return program.error();
    setup.program_ = std::move(*program);
    const lpe::Program& compiled = setup.program_;
    if (compiled.group_count() > Tracker::group_limit)
        return error_at({},
                        "the light path expressions need " + std::to_string(compiled.group_count()) +
                            " words of state; expected at most " + std::to_string(Tracker::group_limit),
                        "ask for fewer channels whose expressions begin with `C.*`, or raise the state cap");
    setup.targets_ = SplatTargets(compiled.view(), setup.channel_of_accept_);
    setup.first_states_.resize(compiled.word_count());
    if (!compiled.advance(compiled.starts().data(), compiled.classify(lpe::Event{}), setup.first_states_.data()))
        setup.first_states_.clear();
    for (const lpe::ChannelSource& source : *sources)
        setup.has_user_events_ = setup.has_user_events_ || source.expression.find('U') != std::string::npos;
    setup.find_reach();
    return setup;
}

LpeServices::LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed, Attribution attribution)
    : setup_(setup),
      table_(table),
      targets_(table.sets() != nullptr ? table.sets()->targets() : setup.targets_),
      seed_(seed),
      attribution_(attribution),
      apart_(setup.prefixed_),
      shares_(setup.prefixes_.size(), unused) {
    sharing_.reserve(setup.prefixes_.size());
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

/// Branch by branch, merging as they come.
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

    const lpe::ProgramView& program = setup_.program_.view();
    const std::size_t words = tracker.groups_;
    const std::size_t target = std::min<std::size_t>(Tracker::capacity, Tracker::state_room / words);
    BranchList branches(words);
    bool whole = tracker.whole_, overflow = false;
    const auto shrink = [&] {
        require_key();
        collapse(branches, target, random_state);
        overflow = true;
    };
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        if (!branches.has_room_for(parts.size())) shrink();
        lpe::State* const next = branches.candidates();  // where each part leads
        std::uint64_t alive = 0;
        bool agree = true;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const bool lives = program.advance(&tracker.state_[branch * words], parts[j].event, next + j * words);
            alive |= std::uint64_t{lives} << j;
            agree = agree && lives == ((alive & 1) != 0) && BranchList::same(next + j * words, next, words);
        }
        const RgbD base = tracker.whole_ ? RgbD(1.0) : tracker.share_[branch].rgb();
        if (agree) {
            if (alive != 0) branches.add(next, base);  // the fractions sum to 1: nothing is split, nothing is rounded
            continue;
        }
        whole = false;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const RgbD share = (alive >> j & 1) != 0 ? base * fractions.of(j) : RgbD();
            if (share.r != 0 || share.g != 0 || share.b != 0) branches.add(next + j * words, share);
        }
    }
    if (branches.count > target) shrink();
    if (overflow) ++overflow_count_;

    tracker.whole_ = whole;
    tracker.count_ = static_cast<std::uint8_t>(branches.count);
    for (std::size_t i = 0; i < branches.count * words; ++i) tracker.state_[i] = branches.state[i];
    for (std::size_t i = 0; i < branches.count && !whole; ++i) tracker.share_[i] = branches.share[i];
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
    for (double Tracker::Share::*const color : {&Tracker::Share::r, &Tracker::Share::g, &Tracker::Share::b}) {
        double total = 0, below = 0;
        for (std::size_t k = 0; k < chosen_count; ++k) total += branches.share[order[k]].*color;
        std::size_t survivor = order[0];
        bool found = false;
        for (std::size_t k = 0; k < chosen_count; ++k) {
            double& share = branches.share[order[k]].*color;
            if (!found && share > 0) survivor = order[k];
            below += share;
            found = found || random * total < below;
            share = 0;
        }
        branches.share[survivor].*color = total;
    }
    branches.compact();
}

/// To channels of a set that the table has no column for.
void LpeServices::splat_apart(std::span<const ChannelId> channels, const RgbD& value, int row) {
    for (const ChannelId id : channels) {
        double* to = table_.values(id) + 3 * static_cast<std::size_t>(row);
        for (int c = 0; c < 3; ++c) to[c] += value[c];
        table_.touch(id, row);
    }
}

/// Once for the camera ray, and once for beauty and each channel that would have taken a part.
void LpeServices::reject(const Rgb& value, const Tracker& tracker) {
    ++invalid_count_;
    table_.count_invalid(tracker.row_, invalid_channel, value);
    if (takes_all(tracker)) table_.count_invalid_of(setup_.beauty_);
    std::vector<std::uint16_t> counted;  // few of these calls are made, so they may allocate
    const lpe::ProgramView& program = setup_.program_.view();
    for (std::size_t branch = 0; branch < tracker.count_; ++branch)
        program.for_each_accepted(&tracker.state_[branch * tracker.groups_], [&](std::uint16_t channel) {
            const ChannelPrefixes& prefixes = setup_.prefixes_[channel];
            if (prefixes.holdouts != tracker.held_out_) return;
            if (prefixes.own_value() && prefixes.noinfinitecheck) return;  // judged by the value that is its own
            if (std::find(counted.begin(), counted.end(), channel) != counted.end()) return;
            counted.push_back(channel);
            table_.count_invalid_of(setup_.channel_of_accept_[channel]);
        });
}

}  // namespace raylex::display
