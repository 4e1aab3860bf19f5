// What an expression must give where the light of every path is known.
//
// In a closed enclosure whose walls all emit the same radiance and scatter by a few lobes of constant albedo (a Lambert
// lobe, an ideal mirror, index-matched sheets in between) radiance is the same along every ray. A path word then
// carries the emitted radiance times the albedos of its events, whatever the shape, the camera and the pixel. An
// expression gives the sum over its words: with its automaton's transitions d, albedos a and what is emitted e,
//
//     x(q) = sum over terminals t of e(t) [d(q, t) accepts] + sum over scatterings s of a(s) x(d(q, s)),
//
// one linear system over the automaton's states. Sheets in a spherical room, around its centre, are crossed by some
// flights between walls and not by others: which, is remembered beside the state (struct Sheets). No image is needed,
// only the expression: a renderer whose layer differs by more than its noise is wrong.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lpe/event.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// An event of the enclosure's paths and what it multiplies light by: an albedo, or the radiance of a terminal.
struct WeightedEvent {
    Event event;
    double weight = 0;
};

/// Spheres about the centre of a spherical room that let `crossing.weight` of the light straight through and do nothing
/// else; the camera stands in the innermost. A flight from the wall crosses those that are wider than the sine of its
/// angle to the normal, each twice. The squared sine of what a Lambert lobe sends out is uniform (Malley's method:
/// Pharr, Jakob and Humphreys, Physically Based Rendering, 4th ed., A.5.3), so it crosses a sheet of radius r with a
/// probability of r^2; a mirror keeps the angle, and with it the sheets.
struct Sheets {
    WeightedEvent crossing;
    std::vector<double> radii;  ///< as shares of the room's: from 0 to 1
};

struct Enclosure {
    std::vector<WeightedEvent> scattering;   ///< R, T and V events, each once; weights from 0 up
    std::vector<WeightedEvent> terminals;    ///< L, O and B events
    Sheets sheets{};                         ///< none
    std::optional<std::uint64_t> max_depth;  ///< scattering events of a path at most; none: any number
};

struct EnclosureTruth {
    double value = 0;
    /// What paths of 0, 1, 2 ... scattering events give: the first few of the sum.
    std::vector<double> by_depth;
};

/// Errors: the expression's own; sheets with radii outside of 0 to 1 or with transmission at walls; albedos that sum to
/// 1 or more without max_depth, so that light has no bound; an expression of more than 3,000 states that paths of the
/// enclosure reach (then max_depth helps).
Result<EnclosureTruth> enclosure_truth(const ChannelSource& expression, const Enclosure& enclosure,
                                       std::size_t depths_shown = 9);

}  // namespace raylex::lpe
