// What paths teach a guide, and how a guide is made from it.
//
// For a region, let C be what a path contributes to its pixel behind a vertex there, over the pixel's mean, and p the
// density with which the path drew its direction. Among all densities that the region's vertices share, the one
// proportional to the root of the mean of (C p)^2 over its paths makes the second moment of the image least (A. Rath
// et al. 2020, "Variance-Aware Path Guiding", with the scattering included in the target). A cell of area a of the
// square (direction_square.h) therefore gets the mass sqrt(a s), where s is the sum of C^2 p over its paths, with p per
// area.
//
// Sums are integers: quantised values are added in any order to the same bits, whatever the number of threads (Law 3).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "transport/paths/guide/guide_tree.h"

namespace raylex::transport {

/// One departure of a path from a vertex.
struct GuideRecord {
    Vec3 position, normal;  ///< normal: the shading normal, zero in a medium
    Vec3 direction;
    bool specular = false;  ///< the direction is that of a specular lobe
    Real distance = 0;      ///< to where the light comes from, as seen through mirrors and glass; 0: unknown
    double square = 0;      ///< C^2
    double density = 0;     ///< p; of a specular direction: the probability of its lobe
    double chance = 0;      ///< the sampler's part of p, without the number of rays and the shares of techniques
    std::uint64_t key = 0;  ///< chooses a neighbouring region that learns from the record
};

class GuideSums {
  public:
    /// The shares of a guide among which each region chooses. 0: the closure draws all directions.
    static constexpr std::array<Real, 5> shares{0, Real(0.25), Real(0.5), Real(0.75), Real(0.9)};

    struct Region {
        std::atomic<std::uint64_t> finds{0};   ///< records with light
        std::atomic<std::uint64_t> guided{0};  ///< of these, records that the guide could have drawn
        std::atomic<std::uint64_t> light{0};   ///< the sum of C over these
        /// The sum of C log(p' / p), with the density p' that each share would give: how much nearer it is to the ideal
        /// density in the sense of Kullback and Leibler (Müller 2019, section 10.5.2). Two's complement.
        std::array<std::atomic<std::uint64_t>, shares.size()> nearer{};
    };

    /// Sums for one round of training with `tree`, which must outlive the object.
    /// Each record of light is shared with so many `neighbours`.
    explicit GuideSums(const GuideTree& tree, int neighbours = most_neighbours);
    static constexpr int most_neighbours = 32;

    /// Adds a record. Returns the density with which the closure alone would have drawn the direction, relative to the
    /// density with which it was drawn; 1 where the region has no guide. Called by many threads at once.
    double add(const GuideRecord& record);

    [[nodiscard]] const GuideTree& tree() const { return tree_; }
    [[nodiscard]] const std::vector<Region>& regions() const { return regions_; }
    /// The sum of C^2 p in the cell 4 node + quadrant.
    [[nodiscard]] double cell(std::size_t number) const {
        return static_cast<double>(cells_[number].load(std::memory_order_relaxed));
    }

  private:
    void learn(const Vec3& position, const Vec3& normal, const Vec3& direction, double value);
    void share_with_neighbours(const GuideRecord& record);

    const GuideTree& tree_;
    const int neighbours_;
    std::vector<Region> regions_;
    std::vector<std::atomic<std::uint64_t>> cells_;
};

struct GuideLimits {
    std::uint64_t finds = 0;  ///< records with light above which a region is halved
    std::size_t nodes = 0;    ///< of all quadtrees; regions stay larger where more would be needed
    bool final = false;       ///< each region gets the share that is expected to pay; otherwise at least a quarter
    double cost = 1;          ///< of a vertex whose direction a guide may draw, over that of one without a guide
};

/// The tree of the next round, or of the render. It is a function of the sums alone.
GuideTree refined(const GuideSums& sums, const GuideLimits& limits);

}  // namespace raylex::transport
