// Closures of points without a surface to scatter light: black, borders between media, and particles of media.
#pragma once

#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/media/phase.h"

namespace raylex::transport {

/// Absorbs everything.
struct BlackClosure {
    [[nodiscard]] static BsdfEvaluation evaluate(const Vec3&, const Vec3&) { return {}; }
    [[nodiscard]] static BsdfSample sample(const Vec3&, Real, const Vec2&) { return {}; }
    [[nodiscard]] static Real pdf(const Vec3&, const Vec3&) { return 0; }
    [[nodiscard]] static Rgb albedo(const Vec3&) { return {}; }
    [[nodiscard]] static constexpr bool has_density() { return false; }
};

/// pbrt's "interface": the path goes straight on, without an event (`s` in the osl dialect).
struct PassThroughClosure : BlackClosure {};

/// Particles of a medium: Henyey-Greenstein's phase function of asymmetry g, in world space and without a cosine. The
/// lobe is a placeholder: the medium reports the event.
struct PhaseClosure {
    Real g;

    [[nodiscard]] BsdfEvaluation evaluate(const Frame& frame, const Vec3& wo, const Vec3& wi) const {
        const Real density = pdf(frame, wo, wi);
        return one_lobe(lobes::diffuse, Rgb(density), density);
    }
    [[nodiscard]] BsdfSample sample(const Frame&, const Vec3& wo, const Vec2& u) const {
        const PhaseSample phase = sample_phase(g, -wo, u);
        BsdfSample result;
        result.wi = phase.wi;
        result.weight = Rgb(1);
        result.pdf = phase.pdf;
        result.lobes.add(lobes::diffuse, Rgb(phase.pdf));
        return result;
    }
    [[nodiscard]] Real pdf(const Frame&, const Vec3& wo, const Vec3& wi) const { return phase_pdf(g, -wo, wi); }
    [[nodiscard]] static Rgb albedo(const Vec3&) { return {}; }
    [[nodiscard]] static constexpr bool has_density() { return true; }
};

}  // namespace raylex::transport
