#include "display/services/lpe_services.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
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
    [[nodiscard]] double of(std::size_t part, int c) const {
        if (proportional_[c]) return static_cast<double>(parts_[part].value[c]) * scale_[c];
        return part == picked_[c] ? 1.0 : 0.0;
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
    std::size_t groups;
    std::array<lpe::State, room * Tracker::group_limit> state;
    std::array<double, 3 * room> share;

    explicit BranchList(std::size_t group_count) : groups(group_count) {}  // leaves the arrays uninitialised

    [[nodiscard]] bool full() const { return count == room; }
    /// Where the states of one more branch go; add() makes it one.
    lpe::State* next_states() { return &state[count * groups]; }
    /// Adds the branch whose states were put into next_states().
    void add(const double* amount) {
        const lpe::State* fresh = next_states();
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

LpeServices::SplitWay LpeServices::way_to_split(Attribution attribution) {
    if (attribution == Attribution::picked) return SplitWay::one_by_one;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx")) return SplitWay::by_plan_avx;
#endif
    return SplitWay::by_plan;
}

LpeServices::LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed, Attribution attribution)
    : setup_(setup),
      table_(table),
      targets_(table.sets() != nullptr ? table.sets()->targets() : setup.targets_),
      seed_(seed),
      attribution_(attribution),
      plans_(setup.program_, std::min<std::size_t>(Tracker::capacity, Tracker::state_room /
                                                                          std::max<std::size_t>(setup.program_.word_count(), 1))),
      split_way_(way_to_split(attribution)),
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

namespace {

/// A share: one register with AVX, two without, the same bits either way. What one event stores the next loads as a whole; in
/// other pieces the processor would wait until the stores are through.
using Quad [[gnu::vector_size(32), gnu::may_alias]] = double;
using Floats [[gnu::vector_size(16)]] = float;
using Bits [[gnu::vector_size(16)]] = std::int32_t;
using Words [[gnu::vector_size(16)]] = std::uint32_t;

/// A bit for each number that has its sign set.
inline int sign_bits(Bits bits) {
#if defined(__SSE2__)
    return __builtin_ia32_movmskps(reinterpret_cast<Floats>(bits));
#else
    int set = 0;
    for (int i = 0; i < 4; ++i) set |= (bits[i] < 0 ? 1 : 0) << i;
    return set;
#endif
}

/// The fractions of a scattering by part. False where a colour gets nothing or a part gives nothing, and where a part is
/// negative, infinite or no number.
template <std::size_t lobes>
[[gnu::always_inline]] inline bool fill_fractions(const LobePart* parts, Quad* fraction) {
    static_assert(sizeof(LobePart) == sizeof(Floats) && offsetof(LobePart, value) == sizeof(float));
    constexpr std::uint32_t past_infinity = 0x00800000;  // lifts infinity and NaN, and nothing finite, to the sign bit
    Quad total{1, 0, 0, 0};
    Bits refused{};
    int given = 0;
    bool all_give = true;
    for (std::size_t j = 0; j < lobes; ++j) {
        Bits bits;
        std::memcpy(&bits, &parts[j], sizeof bits);
        bits &= Bits{0, -1, -1, -1};  // without the event
        refused |= bits | reinterpret_cast<Bits>(reinterpret_cast<Words>(bits) + past_infinity);
        const int gives = sign_bits(bits > 0);
        given |= gives;
        all_give &= gives != 0;
        const auto color = reinterpret_cast<Floats>(bits);
        const Quad value{color[0], color[1], color[2], color[3]};  // one instruction; __builtin_convertvector makes five
        fraction[j] = value;
        total += value;
    }
    if (!(all_give & (given == 0b1110) & (sign_bits(refused) == 0))) return false;
    const Quad scale = 1 / total;
    for (std::size_t j = 0; j < lobes; ++j) fraction[j] *= scale;
    return true;
}

/// The shares of a plan.
[[gnu::always_inline]] inline void apply(const SplitPlans::Row* row, std::size_t count, std::size_t rows, const Quad* shares,
                                         const Quad* factors, Quad* result) {
    const auto at = [](const Quad* first, std::size_t offset) __attribute__((always_inline)) {
        return reinterpret_cast<const Quad*>(reinterpret_cast<const std::byte*>(first) + offset);
    };
    const auto share = [&](std::size_t i) __attribute__((always_inline)) {
        result[i] = *at(shares, row[i].from(0)) * *at(factors, row[i].factor(0)) +
                    *at(shares, row[i].from(1)) * *at(factors, row[i].factor(1));
    };
    switch (count) {  // one jump, where a loop would ask after every share: a tenth of the whole move
        case 8: share(7); [[fallthrough]];
        case 7: share(6); [[fallthrough]];
        case 6: share(5); [[fallthrough]];
        case 5: share(4); [[fallthrough]];
        case 4: share(3); [[fallthrough]];
        case 3: share(2); [[fallthrough]];
        case 2: share(1); [[fallthrough]];
        case 1: share(0); [[fallthrough]];
        case 0: break;
        default:
            for (std::size_t i = 0; i < count; ++i) share(i);
    }
    for (const SplitPlans::Row *further = row + count, *const end = row + rows; further != end; ++further)
        *const_cast<Quad*>(at(result, further->to())) += *at(shares, further->from(0)) * *at(factors, further->factor(0)) +
                                                         *at(shares, further->from(1)) * *at(factors, further->factor(1));
}

}  // namespace

/// The usual way: by a plan. False, and nothing done, where branches could be too many or a lobe or colour carries nothing,
/// so that there may be fewer branches than a plan makes.
template <std::size_t lobes>
[[gnu::always_inline]] inline bool LpeServices::split_by_plan(Tracker& tracker, const LobePart* parts) {
    std::uint64_t events = 0;
    for (std::size_t j = 0; j < lobes; ++j) events = SplitPlans::add_event(events, parts[j].event);
    if (!plans_.knows(tracker.set_)) tracker.set_ = plans_.set_of(tracker.state_.data(), tracker.count_);
    const SplitPlans::Plan& plan = plans_.plan(tracker.set_, events, lobes);
    if (!plan.fits) return false;
    if (!tracker.whole_ || plan.splits) {
        Quad* const factor = reinterpret_cast<Quad*>(factors_.data());
        if (plan.splits && !fill_fractions<lobes>(parts, &factor[SplitPlans::first_lobe])) return false;
        const auto* from = reinterpret_cast<const Quad*>(tracker.shares());
        if (tracker.whole_) from = factor;
        tracker.side_ ^= 1;  // new shares go to the other of the tracker's two sides, so that none is copied
        apply(plans_.rows(plan), plan.count, plan.rows, from, factor, reinterpret_cast<Quad*>(tracker.shares()));
        tracker.whole_ = false;
    }
    ++tracker.moves_;
    tracker.count_ = plan.count;
    tracker.set_ = plan.set;
    const lpe::State* states = plans_.states(plan);
    const std::size_t words = std::size_t{plan.count} * tracker.groups_;
    if (words <= SplitPlans::fixed_copy)  // a copy of fixed size is faster
        std::memcpy(tracker.state_.data(), states, SplitPlans::fixed_copy * sizeof(lpe::State));
    else
        std::memcpy(tracker.state_.data(), states, words * sizeof(lpe::State));
    return true;
}

[[gnu::always_inline]] inline void LpeServices::split_several(Tracker& tracker, std::span<const LobePart> parts) {
    static_assert(SplitPlans::most_lobes == 4);
    if (parts.size() == 2 ? split_by_plan<2>(tracker, parts.data())
        : parts.size() == 3 ? split_by_plan<3>(tracker, parts.data())
                            : parts.size() == 4 && split_by_plan<4>(tracker, parts.data()))
        return;
    split_one_by_one(tracker, parts);
}

void LpeServices::split(Tracker& tracker, std::span<const LobePart> parts) {
    split_several(tracker, parts);
}

#if defined(__x86_64__)
[[gnu::target("avx")]] void LpeServices::split_avx(Tracker& tracker, std::span<const LobePart> parts) {
    split_several(tracker, parts);
}
#else
void LpeServices::split_avx(Tracker& tracker, std::span<const LobePart> parts) { split(tracker, parts); }
#endif

/// Branch by branch, merging as they come.
void LpeServices::split_one_by_one(Tracker& tracker, std::span<const LobePart> parts) {
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
    /// Puts where `event` leads into next_states(); false where nothing can accept.
    const auto step = [&](std::size_t branch, lpe::EventClass event) {
        return program.advance(&tracker.state_[branch * words], event, branches.next_states());
    };
    std::array<lpe::State, Tracker::group_limit> other;
    bool first_alive = false;
    const auto agrees = [&](std::size_t branch, lpe::EventClass event) {
        const bool alive = program.advance(&tracker.state_[branch * words], event, other.data());
        return alive == first_alive && std::equal(other.data(), other.data() + words, branches.next_states());
    };
    constexpr std::array<double, 3> one{1.0, 1.0, 1.0};
    for (std::size_t branch = 0; branch < tracker.count_; ++branch) {
        if (branches.full()) shrink();
        const double* base = tracker.whole_ ? one.data() : &tracker.shares()[branch].r;
        first_alive = step(branch, parts[0].event);
        if (std::all_of(parts.begin() + 1, parts.end(), [&](const LobePart& part) { return agrees(branch, part.event); })) {
            if (first_alive) branches.add(base);  // the parts' fractions sum to 1: nothing is split, nothing is rounded
            continue;
        }
        whole = false;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            if (branches.full()) shrink();
            if (!step(branch, parts[j].event)) continue;
            const std::array<double, 3> share{base[0] * fractions.of(j, 0), base[1] * fractions.of(j, 1),
                                              base[2] * fractions.of(j, 2)};
            if (share[0] == 0 && share[1] == 0 && share[2] == 0) continue;
            branches.add(share.data());
        }
    }
    if (branches.count > target) shrink();
    if (overflow) ++overflow_count_;

    tracker.whole_ = whole;
    tracker.set_ = SplitPlans::unknown_set;
    tracker.count_ = static_cast<std::uint8_t>(branches.count);
    std::copy_n(branches.state.begin(), branches.count * words, tracker.state_.begin());
    for (std::size_t i = 0; i < branches.count && !whole; ++i)
        tracker.shares()[i] = {0, branches.share[3 * i], branches.share[3 * i + 1], branches.share[3 * i + 2]};
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
