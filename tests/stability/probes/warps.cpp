// Warps at the ends of the unit interval: their results for 0 and for the largest number below 1.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/stability/probes/probes.h"
#include "transport/lights/images/environment.h"
#include "transport/materials/bsdf/microfacet.h"
#include "transport/math/sampling.h"
#include "transport/media/medium.h"
#include "transport/media/phase.h"

namespace raylex::experiments {
namespace {

using transport::Real;
using transport::Vec2;
using transport::Vec3;

/// A point's distance from its domain (0 inside) and its density.
struct Drawn {
    double outside = 0;
    double pdf = 1;
};

Drawn direction(const Vec3& w, double pdf) {
    return {std::abs(double(length(w)) - 1), pdf};
}
double beyond(double x, double least, double most) {
    return x >= least && x <= most ? 0 : std::max(least - x, x - most);  // NaN is kept
}

constexpr Real shallow = Real(1e-4);

struct Warp {
    const char* name;
    Drawn (*draw)(const Vec2& u, Real parameter);
};
const Warp warps[] = {
    {"disk",
     [](const Vec2& u, Real) {
         const Vec2 p = transport::sample_disk(u);
         return Drawn{beyond(std::sqrt(double(p.x) * p.x + double(p.y) * p.y), 0, 1), 1};
     }},
    {"disk-polar",
     [](const Vec2& u, Real) {
         const Vec2 p = transport::sample_disk_polar(u);
         return Drawn{beyond(std::sqrt(double(p.x) * p.x + double(p.y) * p.y), 0, 1), 1};
     }},
    // On the horizon the density is 0, and closures reject such a direction.
    {"cosine-hemisphere",
     [](const Vec2& u, Real) {
         const Vec3 w = transport::sample_cosine_hemisphere(u);
         return direction(w, w.z > 0 ? double(transport::cosine_hemisphere_pdf(w.z)) : 1);
     }},
    {"hemisphere",
     [](const Vec2& u, Real) {
         return direction(transport::sample_uniform_hemisphere(u), double(transport::uniform_hemisphere_pdf()));
     }},
    {"sphere",
     [](const Vec2& u, Real) {
         return direction(transport::sample_uniform_sphere(u), double(transport::uniform_sphere_pdf()));
     }},
    {"cone",
     [](const Vec2& u, Real size) {
         return direction(transport::sample_uniform_cone(u, size), double(transport::uniform_cone_pdf(size)));
     }},
    {"triangle",
     [](const Vec2& u, Real) {
         const Vec2 b = transport::sample_uniform_triangle(u);
         return Drawn{beyond(double(b.x), 0, 1) + beyond(double(b.y), 0, 1) + beyond(double(1 - b.x - b.y), 0, 1), 1};
     }},
    {"linear",
     [](const Vec2& u, Real size) {
         const Real x = transport::sample_linear(u.x, 0, size);
         return Drawn{beyond(double(x), 0, 1), u.x == 0 ? 1 : double(transport::linear_pdf(x, 0, size))};
     }},
    {"bilinear",
     [](const Vec2& u, Real size) {
         const Vec2 p = transport::sample_bilinear(u, size, 1, 1, size);
         return Drawn{beyond(double(p.x), 0, 1) + beyond(double(p.y), 0, 1),
                      double(transport::bilinear_pdf(p, size, 1, 1, size))};
     }},
    {"visible-normal",
     [](const Vec2& u, Real alpha) {
         const transport::Ggx ggx{alpha, alpha};
         const Vec3 w = transport::normalize({1, 0, shallow}), m = ggx.sample_visible_normal(w, u);
         return direction(m, double(ggx.d(m)));
     }},
    {"phase",
     [](const Vec2& u, Real g) {
         const transport::PhaseSample sample = transport::sample_phase(g, {0, 0, 1}, u);
         return direction(sample.wi, double(sample.pdf));
     }},
    {"octahedral",
     [](const Vec2& u, Real) {
         const Vec3 w = transport::direction_from_octahedral(u);
         const Vec2 back = transport::octahedral_from_direction(w);
         Drawn drawn = direction(w, 1);
         drawn.outside += beyond(double(back.x), 0, 1) + beyond(double(back.y), 0, 1);
         return drawn;
     }},
    // A flight may have length 0, from which no path can start, but it is never infinite.
    {"free-flight",
     [](const Vec2& u, Real sigma) {
         transport::Medium medium;
         medium.sigma_s = medium.sigma_t = transport::Rgb(sigma);
         medium.scatters = true;
         const auto flight =
             transport::sample_free_flight(medium, transport::Rgb(1), std::numeric_limits<Real>::infinity(), u);
         // The longest flight with 24 bits has -ln 2^-24 = 16.6 mean free paths.
         return Drawn{beyond(double(flight.distance) * double(sigma), 0, 33.28), double(flight.weight.r)};
     }},
};

Result<ProbeResult> warp_outside(const ProbeInput& input) {
    const std::string name = input.word("warp");
    // In the double build the samplers' numbers are still those of float, so the ends are the same.
    const auto number = [&input](const char* which) {
        return std::min(static_cast<Real>(input.number(which)), transport::one_minus_epsilon);
    };
    const Vec2 u{number("u"), number("v")};
    const auto parameter = static_cast<Real>(input.number("parameter", 0.5));
    if (Status given = input.status(); !given) return given.error();
    std::string known;
    for (const Warp& warp : warps) {
        known += std::string(known.empty() ? "" : ", ") + warp.name;
        if (name != warp.name) continue;
        const Drawn drawn = warp.draw(u, parameter);
        ProbeResult result;
        result.expected = 0;
        const bool possible = drawn.pdf > 0 && std::isfinite(drawn.pdf);
        result.measured = possible ? drawn.outside : std::numeric_limits<double>::infinity();
        if (!possible) result.note = "sampled with density " + std::to_string(drawn.pdf);
        return result;
    }
    return error_at(input.where(), "no warp '" + name + "'; expected one of " + known);
}

}  // namespace

std::span<const NamedProbe> warp_probes() {
    static const NamedProbe table[] = {
        {"warp_outside",
         "distance of a warped point from its domain, or of a direction from the unit sphere, for the numbers u, v; "
         "infinite "
         "if the density is 0 or infinite; warp, u, v, parameter (of cone, linear, bilinear, visible-normal, "
         "phase, free-flight)",
         warp_outside}};
    return table;
}

}  // namespace raylex::experiments
