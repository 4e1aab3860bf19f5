#include "transport/media/medium.h"

#include <algorithm>

#include "display/services/elementary.h"
#include "display/services/short_number.h"
#include "transport/geometry/ray.h"
#include "transport/math/sampling.h"
#include "transport/media/flight_numbers.h"

namespace raylex::transport {
namespace {

/// Picks a colour; `u` becomes uniform in [0, 1) again.
int pick(const Rgb& share, Real& u) {
    Real below = 0;
    for (int c = 0; c < 3; ++c) {
        if (u < below + share[c]) {
            u = std::min((u - below) / share[c], one_minus_epsilon);
            return c;
        }
        below += share[c];
    }
    u = one_minus_epsilon;  // rounding left u above the last share
    return share.b > 0 ? 2 : share.g > 0 ? 1 : 0;
}

/// exp(-(sigma - least) distance): the transmittance when all colours are scaled by exp(least distance), which cancels
/// in every ratio and keeps them from underflowing together.
Real relative_transmittance(Real sigma, Real least, Real distance) {
    return sigma > least ? elementary::exp(-(sigma - least) * distance) : 1.0f;
}

/// Below this optical depth, a flight collides with this probability, uniformly along the segment, and its weight
/// compensates. Otherwise collisions in thin haze would be very rare and as bright as fog. Flights that pass get a
/// noise of 0.4 % of a sample.
constexpr Real thin_depth = Real(0x1p-16);

FreeFlight fly_through_haze(const Medium& medium, Real end, const Vec2& u) {
    FreeFlight flight;
    const Real v = joined(u);
    flight.collided = v < thin_depth;
    if (flight.collided) {
        flight.distance = end * (v / thin_depth);
        flight.weight = medium.sigma_s * transmittance(medium, flight.distance) * (end / thin_depth);
    } else {
        flight.distance = end;
        flight.weight = transmittance(medium, end) * (1 / (1 - thin_depth));
    }
    return flight;
}

}  // namespace

Rgb transmittance(const Medium& medium, Real distance) {
    const auto beam_transmittance = [&](Real sigma) {
        return sigma > 0 ? elementary::exp(-sigma * distance) : Real(1);
    };
    if (medium.grey) return Rgb(beam_transmittance(medium.sigma_t.r));
    return {beam_transmittance(medium.sigma_t.r), beam_transmittance(medium.sigma_t.g),
            beam_transmittance(medium.sigma_t.b)};
}

Rgb emission_along(const Medium& medium, Real distance) {
    Rgb result;
    for (int c = 0; c < 3; ++c)
        if (medium.emission[c] > 0)  // a medium that emits also absorbs: sigma_t is above 0
            result[c] = medium.emission[c] * (-elementary::expm1(-medium.sigma_t[c] * distance) / medium.sigma_t[c]);
    return result;
}

FreeFlight sample_free_flight(const Medium& medium, const Rgb& throughput, Real end, const Vec2& u) {
    if (medium.sigma_t.max() * end < thin_depth) return fly_through_haze(medium, end, u);
    FreeFlight flight;
    if (medium.grey) {
        const Real sigma = medium.sigma_t.r;
        flight.distance = sigma > 0 ? optical_depth(u) / sigma : infinity;
        flight.collided = flight.distance < end;
        flight.weight = flight.collided ? medium.sigma_s / sigma : Rgb(1);
        return flight;
    }
    const Rgb share = shares(throughput);
    Real rest = u.x;
    const Real chosen = medium.sigma_t[pick(share, rest)];
    flight.distance = chosen > 0 ? optical_depth({rest, u.y}) / chosen : infinity;
    flight.collided = flight.distance < end;
    const Real distance = flight.collided ? flight.distance : end;
    Real least = infinity;
    for (int c = 0; c < 3; ++c)
        if (share[c] > 0) least = std::min(least, medium.sigma_t[c]);
    Rgb left;
    Real density = 0;
    for (int c = 0; c < 3; ++c) {
        if (!(share[c] > 0)) continue;  // the throughput is black in this colour, and stays so
        left[c] = relative_transmittance(medium.sigma_t[c], least, distance);
        density += share[c] * left[c] * (flight.collided ? medium.sigma_t[c] : 1.0f);
    }
    flight.weight = left / density;
    if (flight.collided) flight.weight *= medium.sigma_s;
    return flight;
}

Real sample_absorption(const Medium& medium, Real end, const Vec2& u) {
    const auto loss = [&](Real sigma) { return sigma > 0 ? -elementary::expm1(-sigma * end) : Real(0); };
    const Rgb lost{loss(medium.sigma_t.r), loss(medium.sigma_t.g), loss(medium.sigma_t.b)};
    Real rest = u.x;
    const int c = pick(shares(lost), rest);
    return std::min(-elementary::log1p(-u.y * lost[c]) / medium.sigma_t[c], end);
}

Rgb brightest_glow(const Medium& medium, Real length) {
    return medium.grid != nullptr ? medium.grid->brightest_emission() * length : emission_along(medium, length);
}

/// Flights visit particle after particle. This many take some milliseconds, and the 24 bits of distances within a cell
/// still distinguish them.
constexpr double most_particles_in_a_cell = 1e7;

std::size_t MediumTable::grid_bytes() const {
    std::size_t bytes = 0;
    for (const Medium& medium : media_) bytes += medium.grid != nullptr ? medium.grid->bytes() : 0;
    return bytes;
}

std::int32_t MediumTable::add(const Medium& medium, const std::string& name) {
    media_.push_back(medium);
    names_.push_back(name);
    any_ = true;
    any_emits_ = any_emits_ || medium.emits;
    any_bodies_ = any_bodies_ || medium.in_body;
    return static_cast<std::int32_t>(media_.size()) - 1;
}

Result<MediumTable> MediumTable::build(const SceneDescription& scene, std::vector<Error>& warnings,
                                       const RenderSpace* space) {
    MediumTable table;
    std::vector<std::uint8_t> used(scene.media.size(), 0);
    const auto use = [&](int index, const SourceLocation& where) -> Status {
        if (index < 0) return success();
        if (static_cast<std::size_t>(index) >= used.size()) return error_at(where, "the medium is not defined");
        used[static_cast<std::size_t>(index)] = 1;
        return success();
    };
    const auto use_all = [&](const std::vector<SceneShape>& shapes) -> Status {
        for (const SceneShape& shape : shapes)
            for (const int index : {shape.inside_medium, shape.outside_medium})
                if (Status s = use(index, shape.location); !s) return s;
        return success();
    };
    if (Status s = use(scene.camera_medium, scene.camera.location); !s) return s.error();
    if (Status s = use_all(scene.shapes); !s) return s.error();
    for (const SceneObject& object : scene.objects)
        if (Status s = use_all(object.shapes); !s) return s.error();

    table.camera_ = scene.camera_medium;
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const SceneMedium& entity = scene.media[i];
        table.names_.push_back(entity.name);
        table.media_.emplace_back();
        if (!used[i]) continue;
        auto entry = medium_registry().require(entity.type, entity.location);
        if (!entry) return entry.error();
        auto medium = (*entry)->factory(entity, {scene, space, warnings});
        if (!medium) return medium.error();
        if (medium->grid != nullptr)
            if (const double met = medium->grid->most_met(); !(met <= most_particles_in_a_cell))
                return error_at(entity.location, "medium '" + entity.name + "' has a cell that is " +
                                                     short_number(met) +
                                                     " mean free paths thick where it is densest and nearly empty "
                                                     "elsewhere; expected at most " +
                                                     short_number(most_particles_in_a_cell));
        for (const Parameter* p : entity.parameters.unused())
            warnings.push_back(error_at(p->location, "parameter '" + p->name + "' has no effect on medium '" +
                                                         entity.name + "' (" + entity.type + ")"));
        table.media_.back() = *medium;
        table.any_ = true;
        table.any_emits_ = table.any_emits_ || medium->emits;
        table.any_grids_ = table.any_grids_ || medium->grid != nullptr;
    }
    return table;
}

}  // namespace raylex::transport
