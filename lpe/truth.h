// The exact value of an expression in a scene where the light of every path is known.
//
// In a closed enclosure whose walls all emit the same radiance and scatter by a few lobes of constant albedo (a Lambert
// lobe, an ideal mirror, index-matched sheets in between), radiance is the same along every ray. A path then carries
// the emitted radiance times the albedos of its events, whatever the shape, the camera and the pixel. The value of an
// expression is the sum over its path strings. With transitions d of its automaton, albedos a and emission e,
//
//     x(q) = sum over terminals t of e(t) [d(q, t) accepts] + sum over scatterings s of a(s) x(d(q, s)),
//
// This is one linear system over the states of the automaton. Some flights between walls of a spherical room cross
// concentric sheets and others do not; the node stores this beside the state (struct Sheets). The computation needs
// only the expression, no image. A renderer whose layer differs by more than its noise is wrong.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lpe/event.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// An event in the enclosure with its factor: an albedo, or the radiance of a terminal.
struct WeightedEvent {
    Event event;
    double weight = 0;
};

/// Spheres around the centre of a spherical room that pass `crossing.weight` of the light straight through and have no
/// other effect; the camera is inside the innermost one. A flight from the wall crosses each sheet whose radius exceeds
/// the sine of the flight's angle to the normal, twice. For a Lambert lobe the squared sine is uniform (Malley's
/// method: Pharr, Jakob and Humphreys, Physically Based Rendering, 4th ed., A.5.3), so a flight crosses a sheet of
/// radius r with probability r^2. A mirror keeps the angle, and with it the sheets.
struct Sheets {
    WeightedEvent crossing;
    std::vector<double> radii;  ///< relative to the radius of the room: between 0 and 1
};

struct Enclosure {
    std::vector<WeightedEvent> scattering;   ///< R, T and V events, each once; weights of at least 0
    std::vector<WeightedEvent> terminals;    ///< L, O and B events
    Sheets sheets{};                         ///< empty by default
    std::optional<std::uint64_t> max_depth;  ///< largest number of scattering events of a path; none: unlimited
};

struct EnclosureTruth {
    double value = 0;
    /// The contributions of paths with 0, 1, 2, ... scattering events: the first terms of the sum.
    std::vector<double> by_depth;
};

/// Computes the value of an expression. Errors: those of the expression; sheets with radii outside 0 to 1, or combined
/// with transmission at walls; albedos whose sum is 1 or more without max_depth, so that light is unbounded; more than
/// 3,000 states that paths of the enclosure reach (max_depth avoids this).
Result<EnclosureTruth> enclosure_truth(const ChannelSource& expression, const Enclosure& enclosure,
                                       std::size_t depths_shown = 9);

}  // namespace raylex::lpe
