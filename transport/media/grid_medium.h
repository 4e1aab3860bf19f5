// Heterogeneous media, and free flights through them by null collisions.
//
// A flight meets particles at the rate of a majorant of the extinction, which is constant in each cell of a coarse grid
// along the ray. A particle is real with probability extinction over majorant (E. R. Woodcock et al. 1965; L.
// Szirmay-Kalos, B. Toth and M. Magdics 2011, "Free Path Sampling in High Resolution Inhomogeneous Participating
// Media"). Where colours differ, the probability is the mean over the colours weighted by the path's throughput,
// updated at every null collision, and weights divide by it: the balance heuristic over the three colours that could
// have led the flight (B. Miller, I. Georgiev and W. Jarosz 2019, "A Null-Scattering Path Integral Formulation of Light
// Transport"). It keeps the throughput's sum unless something is absorbed.
//
// Transmittance is estimated by ratio tracking (J. Novak, A. Selle and W. Jarosz 2014, "Residual Ratio Tracking for
// Estimating Attenuation in Participating Media"): each cell's minimum extinction has its closed form, and the rest is
// estimated by random collisions. All strategies that make a path have the same expectation along each of its segments,
// so densities of flights cancel in MIS weights, as they do in homogeneous media (paths/partial_mis_weights.h).
#pragma once

#include <optional>

#include "transport/media/cell_walk.h"
#include "transport/media/cloud_density.h"
#include "transport/media/emission.h"
#include "transport/media/flight_numbers.h"

namespace raylex::transport {

/// The result of sampling a distance along a path.
struct FreeFlight {
    Real distance = 0;      ///< to the collision
    bool collided = false;  ///< false: the segment's end was reached
    Rgb weight;             ///< transmittance (and sigma_s for a collision) over the probability of the event
};

/// The medium at a point. Coefficients are per unit of world length.
struct MediumPoint {
    Rgb sigma_a, sigma_s;
    Rgb emission;  ///< sigma_a Le
};

/// The parts of a GridMedium. Either `density` or `cloud` scales the coefficients, or `absorption` and `scattering`
/// give them, separately for each colour.
struct GridMediumParts {
    CellFrame frame;
    Rgb sigma_a{1}, sigma_s{1};
    VoxelGrid density;
    VoxelGrid absorption, scattering;
    std::optional<CloudDensity> cloud;
    std::optional<GridEmission> emission;
    Real majorant_factor = 1;  ///< factor on every majorant: more null collisions, the same mean
};

class GridMedium {
  public:
    explicit GridMedium(GridMediumParts parts);

    /// Samples a collision before the segment's end. `throughput` sets the probabilities of the colours and must not be
    /// black. u in [0, 1)^2 draws the first depth; `numbers` draw the rest.
    [[nodiscard]] FreeFlight sample_free_flight(const MediumSegment& segment, const Rgb& throughput, const Vec2& u,
                                                FlightNumbers numbers) const;
    /// An unbiased estimate of the transmittance, in [0, 1] up to the weight of roulette; exact if extinction is
    /// constant in each cell.
    [[nodiscard]] Rgb transmittance(const MediumSegment& segment, FlightNumbers numbers) const;
    /// An estimate of the transmittance, with a distance whose density is the mean over the colours of the attenuation
    /// there. For deep images.
    [[nodiscard]] Rgb transmittance(const MediumSegment& segment, FlightNumbers numbers, Real& lost_at) const;
    /// An unbiased estimate of the radiance that the medium emits along the segment towards its origin.
    [[nodiscard]] Rgb emission(const MediumSegment& segment, FlightNumbers numbers) const;

    /// The medium at a point of render space; all 0 outside of its box.
    [[nodiscard]] MediumPoint at(const Vec3& point) const;
    /// A majorant at a point, over all colours; 0 outside of the box.
    [[nodiscard]] Real majorant(const Vec3& point) const;
    /// The largest majorant of all points.
    [[nodiscard]] Real largest_majorant() const;
    /// An upper bound on the emission per unit of length.
    [[nodiscard]] const Rgb& brightest_emission() const { return brightest_; }
    [[nodiscard]] std::size_t bytes() const;
    /// The corners of the non-empty part, in render space.
    [[nodiscard]] std::array<DVec3, 8> corners() const;
    /// The approximate number of null particles that a path may meet in one cell before it leaves it or meets a real
    /// one.
    [[nodiscard]] double most_met() const;

  private:
    [[nodiscard]] bool coloured() const { return !parts_.absorption.empty(); }
    [[nodiscard]] Real majorant_in(std::size_t cell) const { return static_cast<Real>(bounds_[cell].most) * unit_; }
    [[nodiscard]] Real density(const CellWalk& walk, Real t) const;
    [[nodiscard]] MediumPoint coefficients(std::size_t cell, const Vec3& local, const Vec3& in_box) const;
    [[nodiscard]] Rgb extinction(const CellWalk& walk, Real t) const;
    [[nodiscard]] FreeFlight fly_grey(CellWalk walk, Real end, Real depth, FlightNumbers numbers) const;
    [[nodiscard]] FreeFlight fly_coloured(CellWalk walk, Real end, const Rgb& throughput, Real depth,
                                          FlightNumbers numbers) const;

    GridMediumParts parts_;
    Rgb sigma_t_;
    Real largest_ = 0;  // of sigma_t_; 1 if grids contain the coefficients
    Real unit_ = 0;     // of majorants: largest_ times the factor
    bool grey_ = false;
    std::vector<CellBounds> bounds_;    // [cell]: density, or extinction if colours have grids of their own
    std::vector<std::uint8_t> shines_;  // [cell]; empty: none emits
    Rgb brightest_;
};

}  // namespace raylex::transport
