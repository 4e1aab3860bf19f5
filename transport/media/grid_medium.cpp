#include "transport/media/grid_medium.h"

namespace raylex::transport {
namespace {

/// Below this throughput, Russian roulette ends a ray with probability one half, or doubles the throughput.
constexpr Real least_followed = Real(0.1);

/// Plays Russian roulette; returns false if the ray ends, with nothing left.
bool plays_on(Rgb& left, FlightNumbers& numbers) {
    if (left.max() >= least_followed) return true;
    const bool wins = numbers.next() < Real(0.5);
    left *= wins ? Real(2) : Real(0);
    return wins;
}

/// The factor on each colour after a null collision, whose probability was 1 - extinction / majorant.
Rgb left_over(const Rgb& extinction, Real majorant) {
    const Real inverse = 1 / majorant;
    const auto left = [&](Real e) { return std::max(1 - e * inverse, Real(0)); };
    return {left(extinction.r), left(extinction.g), left(extinction.b)};
}

/// Visits the particles, real or null, along a flight through a Poisson process. `majorant_of()` is its density per
/// unit of distance in the current cell of `walk`; `meet(t, majorant)` is called at each particle and returns whether
/// to continue. `depth` is the optical depth of the first.
template <class Majorant, class Meet>
void fly(CellWalk& walk, Real depth, FlightNumbers& numbers, const Majorant& majorant_of, const Meet& meet) {
    for (; walk.inside(); walk.next()) {
        const Real majorant = majorant_of();
        if (!(majorant > 0)) continue;
        const Real apart = 1 / majorant;
        Real t = walk.begin();
        for (;;) {
            const Real met = t + depth * apart;
            if (!(met < walk.end())) break;
            t = met;
            if (!meet(t, majorant)) return;
            depth = optical_depth(numbers.next_2d());
        }
        depth = std::max(depth - (walk.end() - t) * majorant, Real(0));
    }
}

}  // namespace

GridMedium::GridMedium(GridMediumParts parts) : parts_(std::move(parts)), sigma_t_(parts_.sigma_a + parts_.sigma_s) {
    const std::size_t cells = parts_.frame.box.count();
    grey_ = !coloured() && sigma_t_.r == sigma_t_.g && sigma_t_.g == sigma_t_.b;
    largest_ = coloured() ? 1 : sigma_t_.max();
    unit_ = largest_ * parts_.majorant_factor;
    if (parts_.cloud) bounds_ = parts_.cloud->bounds(parts_.frame.box);
    else bounds_.resize(cells);
    const Real a = parts_.sigma_a.r, s = parts_.sigma_s.r;
    for (std::size_t i = 0; i < cells && !parts_.cloud; ++i) {
        if (!coloured()) {
            bounds_[i] = parts_.density.bounds(i);
            continue;
        }
        const CellBounds absorbs = parts_.absorption.bounds(i), scatters = parts_.scattering.bounds(i);
        bounds_[i] = {to_float(a * static_cast<Real>(absorbs.least) + s * static_cast<Real>(scatters.least)),
                      to_float(a * static_cast<Real>(absorbs.most) + s * static_cast<Real>(scatters.most))};
    }
    if (!parts_.emission) return;
    const GridEmission& emission = *parts_.emission;
    shines_.resize(cells);
    float most = 0;
    for (std::size_t i = 0; i < cells; ++i) {
        shines_[i] = bounds_[i].most > 0 && emission.may_shine(i) ? 1 : 0;
        if (shines_[i] != 0) most = std::max(most, bounds_[i].most);
    }
    brightest_ = emission.brightest() * static_cast<Real>(most);
    if (!coloured()) brightest_ *= parts_.sigma_a;
}

Real GridMedium::largest_majorant() const {
    float most = 0;
    for (const CellBounds& bounds : bounds_) most = std::max(most, bounds.most);
    return static_cast<Real>(most) * unit_;
}

std::size_t GridMedium::bytes() const {
    return parts_.density.bytes() + parts_.absorption.bytes() + parts_.scattering.bytes() +
           bounds_.size() * sizeof(CellBounds) + shines_.size() + (parts_.emission ? parts_.emission->bytes() : 0);
}

std::array<DVec3, 8> GridMedium::corners() const {
    const Matrix34 from_cells = parts_.frame.to_cells.inverse();
    const DVec3 &lower = parts_.frame.lower, &upper = parts_.frame.upper;
    std::array<DVec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] =
            from_cells.point({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
    return corners;
}

double GridMedium::most_met() const {
    const Matrix34 from_cells = parts_.frame.to_cells.inverse();
    double across = 0;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0}) across = std::max(across, length(from_cells.vector({x, y, 1})));
    double met = 0;
    for (const CellBounds& each : bounds_) {
        const double most = static_cast<double>(each.most) * static_cast<double>(unit_);
        const double until_one_is_real = each.least > 0 ? static_cast<double>(each.most / each.least) : infinity;
        met = std::max(met, std::min(most * across, until_one_is_real));
    }
    return met;
}

/// The density of a cloud is clamped to the majorant.
Real GridMedium::density(const CellWalk& walk, Real t) const {
    if (!parts_.cloud) return parts_.density.real(walk.cell(), walk.local(t));
    return std::min(parts_.cloud->in_box(walk.in_box(t)), static_cast<Real>(bounds_[walk.cell()].most));
}

Rgb GridMedium::extinction(const CellWalk& walk, Real t) const {
    if (!coloured()) return sigma_t_ * density(walk, t);
    const Vec3 local = walk.local(t);
    return parts_.absorption.rgb(walk.cell(), local) * parts_.sigma_a +
           parts_.scattering.rgb(walk.cell(), local) * parts_.sigma_s;
}

MediumPoint GridMedium::coefficients(std::size_t cell, const Vec3& local, const Vec3& in_box) const {
    MediumPoint point{parts_.sigma_a, parts_.sigma_s, Rgb(0)};
    if (coloured()) {
        point.sigma_a *= parts_.absorption.rgb(cell, local);
        point.sigma_s *= parts_.scattering.rgb(cell, local);
    } else {
        const Real d = parts_.cloud ? std::min(parts_.cloud->in_box(in_box), static_cast<Real>(bounds_[cell].most))
                                    : parts_.density.real(cell, local);
        point.sigma_a *= d;
        point.sigma_s *= d;
    }
    if (parts_.emission) point.emission = point.sigma_a * parts_.emission->at(cell, local, in_box);
    return point;
}

FreeFlight GridMedium::sample_free_flight(const MediumSegment& segment, const Rgb& throughput, const Vec2& u,
                                          FlightNumbers numbers) const {
    const CellWalk walk(parts_.frame, segment);
    const Real depth = optical_depth(u);
    return grey_ ? fly_grey(walk, segment.end, depth, numbers)
                 : fly_coloured(walk, segment.end, throughput, depth, numbers);
}

FreeFlight GridMedium::fly_grey(CellWalk walk, Real end, Real depth, FlightNumbers numbers) const {
    FreeFlight flight{end, false, Rgb(1)};
    const auto meet = [&](Real t, Real majorant) {
        const Real v = numbers.next() * majorant;
        // The cell's minimum needs no look-up.
        const Real surely = static_cast<Real>(bounds_[walk.cell()].least) * largest_;
        if (!(v < surely || v < density(walk, t) * largest_)) return true;
        flight = {walk.distance(t), true, parts_.sigma_s / largest_};
        return false;
    };
    fly(
        walk, depth, numbers, [&] { return majorant_in(walk.cell()); }, meet);
    return flight;
}

FreeFlight GridMedium::fly_coloured(CellWalk walk, Real end, const Rgb& throughput, Real depth,
                                    FlightNumbers numbers) const {
    FreeFlight flight{end, false, Rgb(1)};
    Rgb share = shares(throughput);
    for (int c = 0; c < 3; ++c)
        if (!(share[c] > 0)) flight.weight[c] = 0;  // the throughput is black in this colour, and stays so
    const auto meet = [&](Real t, Real majorant) {
        const Rgb left = left_over(extinction(walk, t), majorant);
        const Real passes = std::min(share.r * left.r + share.g * left.g + share.b * left.b, Real(1));
        if (numbers.next() < passes) {
            flight.weight *= left / passes;
            share *= left / passes;
            return true;
        }
        const MediumPoint here = coefficients(walk.cell(), walk.local(t), walk.in_box(t));
        flight.distance = walk.distance(t);
        flight.collided = true;
        flight.weight *= here.sigma_s / ((1 - passes) * majorant);
        return false;
    };
    fly(
        walk, depth, numbers, [&] { return majorant_in(walk.cell()); }, meet);
    return flight;
}

Rgb GridMedium::transmittance(const MediumSegment& segment, FlightNumbers numbers) const {
    Real constant = 0;  // the sum of the cells' minima, at a sigma_t of 1
    Rgb ratio(1);
    CellWalk walk(parts_.frame, segment);
    const auto least = [&] { return static_cast<Real>(bounds_[walk.cell()].least); };
    const auto rest_of_majorant = [&] {
        constant += least() * (walk.end() - walk.begin());
        return majorant_in(walk.cell()) - least() * largest_;
    };
    const auto meet = [&](Real t, Real majorant) {
        const Rgb rest = coloured() ? extinction(walk, t) - Rgb(least()) : sigma_t_ * (density(walk, t) - least());
        ratio *= left_over(rest, majorant);
        return plays_on(ratio, numbers);
    };
    const Real depth = optical_depth(numbers.next_2d());
    fly(walk, depth, numbers, rest_of_majorant, meet);
    const auto constant_part = [&](Real sigma) { return elementary::exp(-sigma * constant); };
    if (coloured() || grey_) return ratio * constant_part(largest_);
    return ratio * Rgb(constant_part(sigma_t_.r), constant_part(sigma_t_.g), constant_part(sigma_t_.b));
}

Rgb GridMedium::transmittance(const MediumSegment& segment, FlightNumbers numbers, Real& lost_at) const {
    Rgb left(1);
    Real lost = 0;
    lost_at = segment.end;
    CellWalk walk(parts_.frame, segment);
    const auto meet = [&](Real t, Real majorant) {
        const Real before = left.average();
        left *= left_over(extinction(walk, t), majorant);
        // Keeps one of all losses, with a probability proportional to it.
        const Real loss = before - left.average();
        lost += loss;
        if (loss > 0 && numbers.next() * lost < loss) lost_at = walk.distance(t);
        return !left.is_black();
    };
    const Real depth = optical_depth(numbers.next_2d());
    fly(
        walk, depth, numbers, [&] { return majorant_in(walk.cell()); }, meet);
    return left;
}

Rgb GridMedium::emission(const MediumSegment& segment, FlightNumbers numbers) const {
    Rgb left(1), sum(0);
    if (shines_.empty()) return sum;
    CellWalk walk(parts_.frame, segment);
    const Real once_a_cell = walk.inside() ? walk.cells_per_distance() : Real(0);
    // Thin fire emits too: it is evaluated about once per cell, however rare particles are.
    const auto majorant_of = [&] {
        const Real majorant = majorant_in(walk.cell());
        return shines_[walk.cell()] != 0 ? std::max(majorant, once_a_cell) : majorant;
    };
    const auto meet = [&](Real t, Real majorant) {
        if (shines_[walk.cell()] != 0) {
            const MediumPoint here = coefficients(walk.cell(), walk.local(t), walk.in_box(t));
            sum += left * here.emission / majorant;
            left *= left_over(here.sigma_a + here.sigma_s, majorant);
        } else {
            left *= left_over(extinction(walk, t), majorant);
        }
        return plays_on(left, numbers);
    };
    const Real depth = optical_depth(numbers.next_2d());
    fly(walk, depth, numbers, majorant_of, meet);
    return sum;
}

MediumPoint GridMedium::at(const Vec3& point) const {
    const CellWalk walk(parts_.frame, {point, {0, 0, 1}, infinity});
    if (!walk.inside() || walk.distance(0) > 0) return {};
    return coefficients(walk.cell(), walk.local(0), walk.in_box(0));
}

Real GridMedium::majorant(const Vec3& point) const {
    const CellWalk walk(parts_.frame, {point, {0, 0, 1}, infinity});
    if (!walk.inside() || walk.distance(0) > 0) return 0;
    return majorant_in(walk.cell());
}

}  // namespace raylex::transport
