// The closure a material leaves at a hit: a fixed-size tagged value, evaluated by a switch.
//
// Conventions. Closures live in the shading frame (s, t, n): n is the shading normal as geometry delivers it, on the
// geometric normal's side, which is the outside of dielectrics; s is along dpdu. Both directions may lie on either
// side. Whether light is reflected or transmitted is told by the signs of the cosines to the *shading* normal, as in
// pbrt-v4, and the lobes say which it was; opaque closures have no transmitting lobe, so a path through a leaking
// shading normal is never labelled T. Opaque closures scatter on both sides alike.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "transport/color/wavelengths.h"
#include "transport/materials/bsdf/bsdf.h"
#include "transport/materials/bsdf/compensated.h"
#include "transport/materials/bsdf/diffuse_transmission.h"
#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/closures/custom_closure.h"
#include "transport/materials/closures/hair.h"
#include "transport/materials/closures/ideal.h"
#include "transport/materials/closures/layered.h"
#include "transport/materials/closures/measured.h"
#include "transport/media/phase.h"

namespace raylex::transport {

/// The lobes by which a closure sends back what comes to its outer interface, and what passes that.
struct SideLobes {
    LobeId reflected;
    std::array<LobeId, 2> passed;
};

/// Scattering at one point. All directions are world space, unit, pointing away from the surface. Radiance transport
/// (pbrt's TransportMode::Radiance): transmitted radiance is scaled by 1/eta^2.
class Bsdf {
  public:
    enum class Kind : std::uint8_t {
        black,         ///< absorbs everything
        pass_through,  ///< no surface at all (pbrt's "interface"): the path goes on straight
        lambert,
        conductor,
        dielectric,
        thin_dielectric,
        coated_diffuse,
        coated_conductor,
        additive,
        ideal,
        compensated_conductor,
        compensated_dielectric,
        diffuse_transmission,
        hair,
        measured,
        subsurface,  ///< a dielectric with lobes of its own
        custom,      ///< a plugin's own
        phase        ///< particles of a medium: no surface, no cosine
    };

    Bsdf() : lambert_{} {}

    /// Sum over non-delta lobes of f |cos|, each lobe apart, and the density of sample().
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const;
    /// u_lobe and u in [0, 1). A failed sample has pdf 0. The density is that of the direction as it was rounded: the
    /// same bits as pdf(wo, wi), so that the weights of two strategies for one direction sum to 1.
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const;
    /// Whether any lobe has a density: false means that light sampling is of no use here.
    [[nodiscard]] bool has_density() const { return has_density_; }
    /// Rough estimate of the directional albedo, for the albedo AOV.
    [[nodiscard]] Rgb albedo(const Vec3& wo) const;

    /// Refractive index on the inner side, 1 for what light does not enter.
    [[nodiscard]] Real inside_ior() const {
        if (kind_ == Kind::compensated_dielectric) return compensated_dielectric_.glass.eta;
        return kind_ == Kind::dielectric || kind_ == Kind::subsurface ? dielectric_.eta : 1.0f;
    }

    /// No surface: the integrator continues the ray in its direction, without an event (`s` in the osl dialect). All
    /// other functions answer as for `black`.
    [[nodiscard]] bool passes_through() const { return kind_ == Kind::pass_through; }
    [[nodiscard]] Kind kind() const { return kind_; }
    /// Whether sample() reads its u_lobe.
    [[nodiscard]] bool chooses_lobes() const { return kind_ != Kind::lambert && kind_ != Kind::phase; }
    [[nodiscard]] const Frame& frame() const { return frame_; }
    /// Nothing where it does not choose between the two.
    [[nodiscard]] std::optional<SideLobes> side_lobes() const;
    /// From now on only this side of side_lobes() is drawn, surely, and densities are those; values of the other may be
    /// left out. For camera subpaths.
    void keep_side(Sides side);

    /// Of a dielectric interface (IndexSpectrum): the index on the inner side becomes this one.
    void set_index(Real inside);
    /// Whether it is ideal, and at every index of `indices` some of what comes from wo's side passes: which way
    /// reflected light goes depends on no wavelength, and how much of it is Fresnel's share.
    [[nodiscard]] bool reflects_all_alike(const IndexSpectrum& indices, const Vec3& wo) const;
    /// What such an interface reflects at an index for each colour, over what it does at its own.
    [[nodiscard]] Rgb reflected_colours(const Rgb& inside, const Vec3& wo) const;

    /// Blurs microfacets (Ggx::regularized), smooth ones too: paths that begin to be hard to find become easier, and
    /// caustics softer. pbrt-v4's closures alone: those of raylex: materials have known answers and keep them.
    void regularize();

    // Filling in, by materials. Each replaces what was there. Values that break their closure's invariants (negative or
    // NaN colours) are the caller's to prevent; materials clamp what textures give.
    void set_black() { set_kind(Kind::black, false); }
    void set_pass_through() { set_kind(Kind::pass_through, false); }
    void set(const Frame& frame, const LambertClosure& lambert) {
        frame_ = frame;
        std::construct_at(&lambert_, lambert);
        const bool lit = !lambert.reflectance.is_black();
        set_kind(lit ? Kind::lambert : Kind::black, lit);
    }
    void set(const Frame& frame, const ConductorClosure& conductor) {
        frame_ = frame;
        std::construct_at(&conductor_, conductor);
        set_kind(Kind::conductor, !conductor.is_delta());
    }
    void set(const Frame& frame, const DielectricClosure& dielectric) {
        frame_ = frame;
        std::construct_at(&dielectric_, dielectric);
        set_kind(Kind::dielectric, !dielectric.is_delta());
    }
    /// The interface of a translucent body: its lobes are `specular` and `subsurface`.
    void set_subsurface(const Frame& frame, const DielectricClosure& dielectric) {
        set(frame, dielectric);
        kind_ = Kind::subsurface;
    }
    void set(const Frame& frame, const CompensatedConductor& conductor) {
        frame_ = frame;
        std::construct_at(&compensated_conductor_, conductor);
        set_kind(Kind::compensated_conductor, true);
    }
    void set(const Frame& frame, const CompensatedDielectric& dielectric) {
        frame_ = frame;
        std::construct_at(&compensated_dielectric_, dielectric);
        set_kind(Kind::compensated_dielectric, true);
    }
    void set(const Frame& frame, const ThinDielectricClosure& pane) {
        frame_ = frame;
        std::construct_at(&thin_dielectric_, pane);
        set_kind(Kind::thin_dielectric, false);
    }
    /// `key` feeds the random walks: SurfacePoint::random_key.
    void set(const Frame& frame, const LayeredClosure<LambertClosure>& layered, std::uint32_t key) {
        frame_ = frame;
        std::construct_at(&coated_diffuse_, layered);
        key_ = key;
        set_kind(Kind::coated_diffuse, true);
    }
    void set(const Frame& frame, const LayeredClosure<ConductorClosure>& layered, std::uint32_t key) {
        frame_ = frame;
        std::construct_at(&coated_conductor_, layered);
        key_ = key;
        set_kind(Kind::coated_conductor, !layered.is_delta());
    }
    void set(const Frame& frame, const AdditiveClosure& additive) {
        frame_ = frame;
        std::construct_at(&additive_, additive);
        set_kind(Kind::additive, true);
    }
    void set(const Frame& frame, const IdealClosure& ideal) {
        frame_ = frame;
        std::construct_at(&ideal_, ideal);
        set_kind(Kind::ideal, !ideal.diffuse.is_black());
    }
    void set(const Frame& frame, const DiffuseTransmissionClosure& leaf) {
        frame_ = frame;
        std::construct_at(&diffuse_transmission_, leaf);
        const bool lit = !leaf.reflectance.is_black() || !leaf.transmittance.is_black();
        set_kind(lit ? Kind::diffuse_transmission : Kind::black, lit);
    }
    /// s of the frame: along the fibre.
    void set(const Frame& frame, const HairClosure& hair) {
        frame_ = frame;
        std::construct_at(&hair_, hair);
        set_kind(Kind::hair, true);
    }
    void set(const Frame& frame, const MeasuredClosure& measured) {
        frame_ = frame;
        std::construct_at(&measured_, measured);
        set_kind(Kind::measured, true);
    }
    /// Henyey-Greenstein's phase function of asymmetry g. Its lobe says nothing: the event is the medium's.
    void set_phase(Real g) {
        std::construct_at(&phase_g_, g);
        set_kind(Kind::phase, true);
    }
    /// A plugin's closure; custom_closure.h says what it is.
    template <ScatteringClosure Closure>
    void set_custom(const Frame& frame, const Closure& closure) {
        frame_ = frame;
        std::construct_at(&custom_, closure);
        set_kind(Kind::custom, closure.has_density());
    }

  private:
    void set_kind(Kind kind, bool has_density) {
        kind_ = kind;
        sides_ = Sides::both;
        has_density_ = has_density;
    }
    [[nodiscard]] BsdfEvaluation evaluate_other(const Vec3& wo, const Vec3& wi) const;
    [[nodiscard]] BsdfSample sample_other(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] BsdfSample draw(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] Real pdf_other(const Vec3& wo, const Vec3& wi) const;

    Frame frame_;
    std::uint32_t key_ = 0;
    Kind kind_ = Kind::black;
    bool has_density_ = false;
    Sides sides_ = Sides::both;
    union {
        LambertClosure lambert_;
        ConductorClosure conductor_;
        DielectricClosure dielectric_;
        ThinDielectricClosure thin_dielectric_;
        LayeredClosure<LambertClosure> coated_diffuse_;
        LayeredClosure<ConductorClosure> coated_conductor_;
        AdditiveClosure additive_;
        IdealClosure ideal_;
        CompensatedConductor compensated_conductor_;
        CompensatedDielectric compensated_dielectric_;
        DiffuseTransmissionClosure diffuse_transmission_;
        HairClosure hair_;
        MeasuredClosure measured_;
        CustomClosure custom_;
        Real phase_g_;
    };
};

// The plain diffuse surface is most of most scenes: it is answered here, without a call and without the frame's
// tangents where a cosine will do.

inline BsdfEvaluation Bsdf::evaluate(const Vec3& wo, const Vec3& wi) const {
    if (kind_ != Kind::lambert) [[unlikely]]
        return evaluate_other(wo, wi);
    BsdfEvaluation result;
    const Real cos_i = dot(wi, frame_.n);
    if (!(cos_i * dot(wo, frame_.n) > 0)) return result;
    result.pdf = std::abs(cos_i) * inv_pi;
    result.value = lambert_.reflectance * result.pdf;
    result.lobes.add(lobes::diffuse, result.value);
    return result;
}

inline Real Bsdf::pdf(const Vec3& wo, const Vec3& wi) const {
    if (kind_ != Kind::lambert) [[unlikely]]
        return pdf_other(wo, wi);
    const Real cos_i = dot(wi, frame_.n);
    return cos_i * dot(wo, frame_.n) > 0 ? std::abs(cos_i) * inv_pi : 0.0f;
}

inline BsdfSample Bsdf::sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
    if (kind_ != Kind::lambert) [[unlikely]]
        return sample_other(wo, u_lobe, u);
    BsdfSample result;
    const Real cos_o = dot(wo, frame_.n);
    if (cos_o == 0) return result;
    const Vec3 local = sample_cosine_hemisphere(u);
    result.wi = frame_.s * local.x + frame_.t * local.y + frame_.n * std::copysign(local.z, cos_o);
    const Real cos_i = dot(result.wi, frame_.n);  // of the direction as it was rounded: what pdf() will find
    if (!(cos_i * cos_o > 0)) return result;
    result.pdf = std::abs(cos_i) * inv_pi;
    result.weight = lambert_.reflectance;
    result.lobes.add(lobes::diffuse, lambert_.reflectance * result.pdf);
    return result;
}

}  // namespace raylex::transport
