// Media that differ from place to place, and flights through them by null collisions.
//
// A flight meets particles as often as a majorant of the extinction says, constant in each cell of a coarse grid that a
// ray walks through, and what it meets there is real with the chance of the extinction over the majorant (E. R.
// Woodcock et al. 1965; L. Szirmay-Kalos, B. Toth and M. Magdics 2011, "Free Path Sampling in High Resolution
// Inhomogeneous Participating Media"). Where colours differ, the chance is the mean over the colours by the path's
// throughput, updated at every null collision, and weights divide by it: the balance heuristic over the three colours
// that could have led the flight (B. Miller, I. Georgiev and W. Jarosz 2019, "A Null-Scattering Path Integral
// Formulation of Light Transport"), which keeps the throughput's sum unless something is absorbed.
//
// Transmittance is estimated by ratio tracking (J. Novak, A. Selle and W. Jarosz 2014, "Residual Ratio Tracking for
// Estimating Attenuation in Participating Media"): each cell's least extinction has its closed form, the rest is met by
// chance. Every strategy that makes a path has the same expectation along each of its segments, so densities of flights
// cancel in weights, as they do in homogeneous media (paths/partial_mis_weights.h).
#pragma once

#include <optional>

#include "transport/media/cell_walk.h"
#include "transport/media/cloud_density.h"
#include "transport/media/emission.h"
#include "transport/media/flight_numbers.h"

namespace raylex::transport {

/// How far a path flies.
struct FreeFlight {
    Real distance = 0;      ///< of the collision
    bool collided = false;  ///< false: the segment's end was reached
    Rgb weight;             ///< transmittance (and sigma_s for a collision) over the chance of what happened
};

/// What a medium is somewhere. Coefficients per unit of world length.
struct MediumPoint {
    Rgb sigma_a, sigma_s;
    Rgb emission;  ///< sigma_a Le
};

/// What a GridMedium is made of. Either `density` or `cloud` scales the coefficients, or `absorption` and `scattering`
/// do, each colour apart.
struct GridMediumParts {
    CellFrame frame;
    Rgb sigma_a{1}, sigma_s{1};
    VoxelGrid density;
    VoxelGrid absorption, scattering;
    std::optional<CloudDensity> cloud;
    std::optional<GridEmission> emission;
    Real majorant_factor = 1;  ///< on every majorant: more null collisions, the same mean
};

class GridMedium {
  public:
    explicit GridMedium(GridMediumParts parts);

    /// Samples a collision in front of the segment's end. `throughput` decides the odds of the colours; it must not be
    /// black. u in [0, 1)^2 is for the first depth; `numbers` for what follows.
    [[nodiscard]] FreeFlight sample_free_flight(const MediumSegment& segment, const Rgb& throughput, const Vec2& u,
                                                FlightNumbers numbers) const;
    /// An unbiased estimate in [0, 1] up to the weight of roulette; exact where extinction is constant in each cell.
    [[nodiscard]] Rgb transmittance(const MediumSegment& segment, FlightNumbers numbers) const;
    /// The same with a distance whose density is that of what the colours lose in the mean. For deep images.
    [[nodiscard]] Rgb transmittance(const MediumSegment& segment, FlightNumbers numbers, Real& lost_at) const;
    /// An unbiased estimate of the radiance that it sends back along the segment towards its origin.
    [[nodiscard]] Rgb emission(const MediumSegment& segment, FlightNumbers numbers) const;

    /// At a point of render space; nothing outside of its box.
    [[nodiscard]] MediumPoint at(const Vec3& point) const;
    /// A majorant there, of all colours, and 0 outside.
    [[nodiscard]] Real majorant(const Vec3& point) const;
    /// Of all its points.
    [[nodiscard]] Real largest_majorant() const;
    /// Above which no unit of length shines.
    [[nodiscard]] const Rgb& brightest_emission() const { return brightest_; }
    [[nodiscard]] std::size_t bytes() const;
    /// Corners of what holds anything, in render space.
    [[nodiscard]] std::array<DVec3, 8> corners() const;
    /// Null particles, about, that a path may meet in one cell before it leaves it or meets a real one.
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
    Real largest_ = 0;  // of sigma_t_; 1 where grids hold the coefficients
    Real unit_ = 0;     // of majorants: that, times the factor
    bool grey_ = false;
    std::vector<CellBounds> bounds_;    // [cell]: density, or where colours have their own, extinction
    std::vector<std::uint8_t> shines_;  // [cell]; empty: nothing does
    Rgb brightest_;
};

}  // namespace raylex::transport
