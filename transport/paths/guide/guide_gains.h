// Roulette and splitting by expected gain (A. Rath, P. Grittmann, S. Herholz, P. Weier and P. Slusallek 2022, "EARS:
// Efficiency-Aware Russian Roulette and Splitting").
//
// A path arrives with throughput T at a vertex in a region. Let S be the mean square of the light that it finds later,
// over T^2, and R the mean number of rays that follow. Let V be the variance of all that continuing finds for a camera
// path, and C its number of rays. The product of the image's variance and cost is least where m = T sqrt(S / R x C / V)
// rays leave the vertex: below 1 a probability, above 1 (with the variance in the place of S) a number of branches.
//
// In training, S, R and V are those of few and badly guided paths. A number of rays that is f times the best one costs
// about as much as one that is 1 / f times the best, and little where f is near 1. So sqrt(m) rays leave a vertex in
// training: they lose little where m is right, and much less than m rays where it is wrong. In the image m rays leave.
//
// The number of light samples follows from the same formula. S is then the mean square of what light samples find, and
// R is the cost of a light sample. A vertex of the image takes its light sample with the probability m, at most 1. So
// vertices at which light samples find nothing leave out most of them.
//
// The number depends on the training, the throughput and the vertex, and never on samples that it weighs: the image is
// unbiased.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "transport/paths/guide/guide_tree.h"
#include "transport/paths/plan/later_radiance.h"

namespace raylex::transport {

inline constexpr Real least_survival = Real(0.05), most_branches = 8;

/// The mean number of rays that leave a vertex in `region`, in [least_survival, most_branches], and at least 1/4 in
/// training. `throughput`: its mean colour.
Real rays_by_gain(const GuideTree::Region& region, Real throughput, bool training);
/// The probability with which a vertex in `region` takes a light sample, in [least_survival, 1]. `throughput`: its mean
/// colour.
Real light_share_by_gain(const GuideTree::Region& region, Real throughput);

/// What paths through a part of the image find later, over the image's mean. Added in the order of pixels.
struct LaterLight {
    double variance = 0;          ///< the sum over samples
    std::uint64_t rays = 0;       ///< of the camera and of scattering
    double sum = 0, squares = 0;  ///< of the pixel at hand

    void add(double light, std::uint64_t rays_of_path);
    /// All `samples` of a pixel were added.
    void end_pixel(double samples);
};

/// Sums over the departures of paths from the regions of a tree, in a round of training. They are integers, so they do
/// not depend on the order of threads (Law 3).
class GainSums {
  public:
    /// `tree` must outlive the object. `mean`: of the image.
    GainSums(const GuideTree& tree, double mean) : tree_(tree), mean_(mean), regions_(tree.regions().size()) {}
    /// Adds a path with one channel, whose vertices took all their light samples. Called by many threads at once;
    /// `later` is the caller's own.
    void add(const LaterRadiance::Path& path, LaterLight& later);
    /// Sets the gains of `refined`, the tree that was made of this one. `of_paths`: the sums over all paths.
    void set_gains(GuideTree& refined, const LaterLight& of_paths) const;

  private:
    struct Region {
        std::atomic<std::uint64_t> departures{0}, rays{0};   // rays: these, and all that follow
        std::atomic<std::uint64_t> light{0}, squares{0};     // over the throughput and the image's mean
        std::atomic<std::uint64_t> vertices{0}, sampled{0};  // vertices that took light samples, and their squares
    };
    const GuideTree& tree_;
    const double mean_;
    std::vector<Region> regions_;
};

}  // namespace raylex::transport
