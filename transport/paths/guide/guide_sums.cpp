#include "transport/paths/guide/guide_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "display/services/elementary.h"
#include "display/services/split_mix.h"
#include "transport/paths/guide/direction_square.h"

namespace raylex::transport {
namespace {

constexpr Real training_share = Real(0.25);  // at least
// A cell gets at least this share of its region's records, or quadtrees would repeat the noise of few records.
constexpr double finds_of_cell = 6;
constexpr double prior_finds = 0.5;  // records that each quadrant of a node has before the first
// Places with which a record of light is shared are up to this part of the distance to the light away.
constexpr Real reach = Real(0.5);
constexpr float least_cell = 0.01f;  // share of a quadtree's mass below which a quadrant is not divided (Müller 2017)
// Fewer records than this decide nothing by themselves: the mean over all regions counts as so many.
constexpr double prior_records = 64;
constexpr double least_ratio = 1e-4;  // of densities in a logarithm

/// A sum of up to 2^26 values stays below 2^63.
std::uint64_t quantised(double value) {
    constexpr double unit = 0x1p22, most = 0x1p15;
    return value > 0 ? static_cast<std::uint64_t>(std::min(value, most) * unit + 0.5) : 0;
}

void add_to(std::atomic<std::uint64_t>& sum, std::uint64_t value) {
    if (value != 0) sum.fetch_add(value, std::memory_order_relaxed);
}

double value_of(const std::atomic<std::uint64_t>& sum) {
    return static_cast<double>(sum.load(std::memory_order_relaxed));
}

double signed_value_of(const std::atomic<std::uint64_t>& sum) {
    return static_cast<double>(static_cast<std::int64_t>(sum.load(std::memory_order_relaxed)));
}

Vec3 shifted(const Vec3& position, const Vec3& extent, std::uint64_t key) {
    const auto part = [&](int i) {
        return static_cast<Real>(static_cast<std::int64_t>(key >> (21 * i) & 0x1fffff)) * Real(0x1p-21) - Real(0.5);
    };
    return {position.x + part(0) * extent.x, position.y + part(1) * extent.y, position.z + part(2) * extent.z};
}

}  // namespace

GuideSums::GuideSums(const GuideTree& tree, int neighbours)
    : tree_(tree), neighbours_(neighbours), regions_(tree.regions().size()), cells_(4 * tree.node_count()) {}

double GuideSums::add(const GuideRecord& r) {
    const GuideTree::Place place = tree_.place_of(r.position, r.normal);
    const GuideTree::Region& guide = tree_.region(place.region);
    const double share = double{guide.share};
    // The sampler's density is share x by_guide + (1 - share) x by_closure.
    const double by_guide = r.specular || !(share > 0) ? 0 : double{tree_.density(guide, r.direction)};
    const double by_closure = std::max(0.0, r.chance - share * by_guide) / (1 - share);
    if (r.square > 0) {
        Region& sums = regions_[place.region];
        sums.finds.fetch_add(1, std::memory_order_relaxed);
        if (share > 0) {
            sums.guided.fetch_add(1, std::memory_order_relaxed);
            const double light = std::sqrt(r.square);
            add_to(sums.light, quantised(light));
            for (std::size_t k = 0; k < shares.size(); ++k) {
                const double then = double{shares[k]} * by_guide + (1 - double{shares[k]}) * by_closure;
                const double nearer = elementary::log(std::max(then / r.chance, least_ratio));
                const std::uint64_t amount = quantised(light * std::abs(nearer));
                add_to(sums.nearer[k], nearer < 0 ? 0 - amount : amount);
            }
        }
        if (!r.specular) {
            // The record counts where a box of the region's size around it falls (Müller 2019, "Practical Path Guiding
            // in Production", section 10.5.3): neighbours learn from one another.
            const Vec3 at = shifted(r.position, tree_.extent(place), mix_bits(r.key));
            learn(at, r.normal, r.direction, r.square * r.density);
            if (r.distance > 0) share_with_neighbours(r);
        }
    }
    return r.chance > 0 ? by_closure / r.chance : 1;
}

void GuideSums::learn(const Vec3& position, const Vec3& normal, const Vec3& direction, double value) {
    const GuideTree::Region& learns = tree_.region(tree_.place_of(position, normal).region);
    add_to(cells_[tree_.cell_of(learns, direction)], quantised(value / double{square_per_steradian(direction)}));
}

/// Surfaces around the vertex see the same light in other directions, and under another solid angle.
void GuideSums::share_with_neighbours(const GuideRecord& r) {
    const Vec3 target = r.position + r.direction * r.distance;
    const Real width = 2 * reach * r.distance;
    std::uint64_t key = r.key;
    for (int i = 0; i < neighbours_; ++i) {
        key += golden_gamma;
        Vec3 at = shifted(r.position, {width, width, width}, mix_bits(key));
        at = at - r.normal * dot(r.normal, at - r.position);
        const Vec3 way = target - at;
        const Real square = dot(way, way);
        if (!(square > 0) || dot(r.normal, way) * dot(r.normal, r.direction) < 0) continue;
        regions_[tree_.place_of(at, r.normal).region].finds.fetch_add(1, std::memory_order_relaxed);
        learn(at, r.normal, way / std::sqrt(square), r.square * r.density * double{r.distance * r.distance / square});
    }
}

class GuideRefinement {
  public:
    GuideRefinement(const GuideSums& sums, const GuideLimits& limits)
        : sums_(sums), old_(sums.tree()), limits_(limits), masses_(old_.nodes_.size()) {
        find_masses();
        find_common_nearness();
    }
    /// Regions with more than `finds` records are halved. Nothing if there are too many nodes.
    bool build(GuideTree& tree, std::uint64_t finds) {
        tree_ = &tree;
        finds_ = finds;
        tree.space_.assign(GuideTree::orientations, {});
        tree.regions_.clear();
        tree.nodes_.resize(1);
        for (std::uint32_t i = 0; i < GuideTree::orientations; ++i) copy(i, i, 0);
        return tree.nodes_.size() <= limits_.nodes;
    }
    [[nodiscard]] GuideTree unchanged() const {
        GuideTree tree = old_;
        for (std::uint32_t i = 0; i < tree.regions_.size(); ++i) tree.regions_[i].before = i;
        return tree;
    }

  private:
    using Masses = std::array<float, 4>;
    static float total(const Masses& m) { return m[0] + m[1] + (m[2] + m[3]); }

    void find_masses();
    void find_common_nearness();
    void copy(std::uint32_t from, std::uint32_t to, std::uint32_t depth);
    void divide(std::uint32_t region, std::uint64_t finds, std::uint32_t to, std::uint32_t depth);
    void grow(std::uint32_t to, std::uint32_t from, Masses masses, std::uint32_t depth, float least, bool learned);
    static Masses shares_of(const GuideTree::Node& n) {
        return {to_float(n.share(0)), to_float(n.share(1)), to_float(n.share(2)), to_float(n.share(3))};
    }
    static std::array<std::uint16_t, 4> in_whole(const Masses& masses);
    [[nodiscard]] Real share_of(std::uint32_t region) const;

    const GuideSums& sums_;
    const GuideTree& old_;
    const GuideLimits& limits_;
    std::vector<Masses> masses_;                             // of the old nodes, learned in this round
    std::array<double, GuideSums::shares.size()> common_{};  // GuideSums::Region::nearer over light, in all regions
    GuideTree* tree_ = nullptr;
    std::uint64_t finds_ = 0;
    float prior_ = 0;  // mass of a quadrant beside that of its records
};

void GuideRefinement::find_masses() {
    std::vector<std::uint8_t> depths(masses_.size(), 0);
    for (std::size_t n = 1; n < masses_.size(); ++n)
        for (std::uint32_t q = 0; q < 4; ++q)
            if (const std::uint32_t child = old_.nodes_[n].child(q); child != 0)
                depths[child] = static_cast<std::uint8_t>(depths[n] + 1);
    for (std::size_t n = masses_.size(); n-- > 1;)
        for (std::uint32_t q = 0; q < 4; ++q) {
            const std::uint32_t child = old_.nodes_[n].child(q);
            masses_[n][q] =
                child != 0
                    ? total(masses_[child])
                    : static_cast<float>(std::sqrt(std::ldexp(sums_.cell(4 * n + q), -2 * (int{depths[n]} + 1))));
        }
}

/// Rounds masses to parts of Node::whole. No quadrant with a mass loses all of it.
std::array<std::uint16_t, 4> GuideRefinement::in_whole(const Masses& masses) {
    constexpr auto whole = static_cast<int>(GuideTree::Node::whole);
    const float scale = static_cast<float>(whole) / total(masses);
    std::array<int, 4> parts{};
    int rest = whole;
    for (std::size_t q = 0; q < 4; ++q) {
        parts[q] = masses[q] > 0 ? std::max(1, static_cast<int>(masses[q] * scale)) : 0;
        rest -= parts[q];
    }
    *std::max_element(parts.begin(), parts.end()) += rest;
    std::array<std::uint16_t, 4> result{};
    std::copy(parts.begin(), parts.end(), result.begin());
    return result;
}

void GuideRefinement::find_common_nearness() {
    double light = 0;
    for (const GuideSums::Region& region : sums_.regions()) {
        light += value_of(region.light);
        for (std::size_t k = 0; k < common_.size(); ++k) common_[k] += signed_value_of(region.nearer[k]);
    }
    for (double& each : common_) each = light > 0 ? each / light : 0;
}

void GuideRefinement::copy(std::uint32_t from, std::uint32_t to, std::uint32_t depth) {
    const GuideTree::Space& old = old_.space_[from];
    if (old.first == 0) {
        const std::uint64_t finds = sums_.regions()[old.region].finds.load(std::memory_order_relaxed);
        return divide(old.region, finds, to, depth);
    }
    const auto first = static_cast<std::uint32_t>(tree_->space_.size());
    tree_->space_[to].first = first;
    tree_->space_.resize(first + 2);
    copy(old.first, first, depth + 1);
    copy(old.first + 1, first + 1, depth + 1);
}

void GuideRefinement::divide(std::uint32_t region, std::uint64_t finds, std::uint32_t to, std::uint32_t depth) {
    if (tree_->nodes_.size() > limits_.nodes) return;  // the tree will be dropped
    if (finds > finds_ && depth < GuideTree::most_halvings) {
        const auto first = static_cast<std::uint32_t>(tree_->space_.size());
        tree_->space_[to].first = first;
        tree_->space_.resize(first + 2);
        divide(region, finds / 2, first, depth + 1);
        divide(region, finds / 2, first + 1, depth + 1);
        return;
    }
    const std::uint32_t root = old_.regions_[region].root;
    const bool learned = total(masses_[root]) > 0;
    const Masses masses = learned ? masses_[root] : shares_of(old_.nodes_[root]);
    GuideTree::Region fresh;
    fresh.before = region;
    const double found =
        std::max<double>(1, static_cast<double>(sums_.regions()[region].finds.load(std::memory_order_relaxed)));
    const float least = std::max(least_cell, static_cast<float>(finds_of_cell / found)) * total(masses);
    prior_ = static_cast<float>(prior_finds / found) * total(masses);
    fresh.root = static_cast<std::uint32_t>(tree_->nodes_.size());
    tree_->nodes_.emplace_back();
    grow(fresh.root, root, masses, 0, least, learned);
    const bool known = learned || old_.regions_[region].share > 0;
    fresh.share = known ? share_of(region) : Real(0);
    if (known && !limits_.final) fresh.share = std::max(fresh.share, training_share);
    tree_->space_[to] = {0, static_cast<std::uint32_t>(tree_->regions_.size())};
    tree_->regions_.push_back(fresh);
}

/// Makes the node `to` from the old node `from` (0: a part of a cell), with these masses.
void GuideRefinement::grow(std::uint32_t to, std::uint32_t from, Masses masses, std::uint32_t depth, float least,
                           bool learned) {
    std::uint32_t divided = 0;
    for (std::uint32_t q = 0; q < 4; ++q)
        if (masses[q] > least && depth + 1 < GuideTree::deepest_node) divided |= 1u << q;
    const auto first = static_cast<std::uint32_t>(tree_->nodes_.size());
    tree_->nodes_.resize(first + static_cast<std::size_t>(std::popcount(divided)));
    Masses shares = masses;
    if (learned)
        for (float& each : shares) each += prior_;
    tree_->nodes_[to].mass = in_whole(shares);
    tree_->nodes_[to].first_and_divided = first << 4 | divided;
    if (tree_->nodes_.size() > limits_.nodes) return;  // the tree will be dropped
    for (std::uint32_t q = 0; q < 4; ++q) {
        const std::uint32_t grown = tree_->nodes_[to].child(q);
        if (grown == 0) continue;
        const std::uint32_t child = from == 0 ? 0 : old_.nodes_[from].child(q);
        const float quarter = masses[q] / 4;
        Masses below{quarter, quarter, quarter, quarter};
        if (child != 0 && learned) below = masses_[child];
        else if (child != 0)
            for (std::size_t k = 0; k < 4; ++k) below[k] = masses[q] * to_float(old_.nodes_[child].share(k));
        grow(grown, child, below, depth + 1, least, learned);
    }
}

/// The share whose density is nearest to the ideal one. A guide has to gain what it costs.
Real GuideRefinement::share_of(std::uint32_t region) const {
    const GuideSums::Region& sums = sums_.regions()[region];
    const double records = value_of(sums.guided), light = value_of(sums.light);
    const double prior = prior_records * (records > 0 ? light / records : 1);
    double most = 0;
    Real best = 0;
    for (std::size_t k = 0; k < GuideSums::shares.size(); ++k) {
        double nearness = signed_value_of(sums.nearer[k]) + prior * common_[k];
        if (k > 0) nearness -= (light + prior) * elementary::log(limits_.cost);
        if (k > 0 && !(nearness > most)) continue;
        most = nearness;
        best = GuideSums::shares[k];
    }
    return best;
}

GuideTree refined(const GuideSums& sums, const GuideLimits& limits) {
    GuideRefinement refinement(sums, limits);
    GuideTree tree = sums.tree();
    std::uint64_t finds = std::max<std::uint64_t>(limits.finds, 1);
    std::uint64_t most = 0;
    for (const GuideSums::Region& region : sums.regions()) most = std::max(most, region.finds.load());
    while (!refinement.build(tree, finds)) {
        // No region would be halved any more, and the quadtrees alone need too many nodes.
        if (finds > most) return refinement.unchanged();
        finds *= 2;
    }
    return tree;
}

}  // namespace raylex::transport
