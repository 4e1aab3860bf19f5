// The closure that a material leaves at a hit: a small value that batches copy, evaluated by a switch over its type.
//
// Conventions. Closures live in the shading frame (s, t, n): n is the shading normal as geometry delivers it, on the
// geometric normal's side, which is the outside of dielectrics; s is along dpdu. Both directions may lie on either
// side. The signs of the cosines to the *shading* normal decide whether light is reflected or transmitted, as in
// pbrt-v4, and the lobes say which it was; opaque closures have no transmitting lobe, so a path through a leaking
// shading normal is never labelled T. Opaque closures scatter on both sides alike.
//
// closure_types.h lists the types of closures and the functions that each of them has.
#pragma once

#include <optional>

#include "transport/color/wavelengths.h"
#include "transport/materials/closures/closure_types.h"

namespace raylex::transport {

/// Scattering at one point. All directions are world space, unit, pointing away from the surface. Radiance transport
/// (pbrt's TransportMode::Radiance): transmitted radiance is scaled by 1/eta^2.
class Bsdf {
  public:
    /// Sum over non-delta lobes of f |cos|, each lobe apart, and the density of sample().
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        if (const auto* lambert = std::get_if<LambertClosure>(&closure_)) [[likely]]
            return lambert->evaluate(frame_, wo, wi);
        return evaluate_other(wo, wi);
    }
    /// u_lobe and u in [0, 1). A failed sample has pdf 0. The density is that of the direction as it was rounded: the
    /// same bits as pdf(wo, wi), so that the weights of two strategies for one direction sum to 1.
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        if (const auto* lambert = std::get_if<LambertClosure>(&closure_)) [[likely]]
            return lambert->sample(frame_, wo, u);
        return sample_other(wo, u_lobe, u);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const {
        if (holds<LambertClosure>()) [[likely]]
            return LambertClosure::pdf(frame_, wo, wi);
        return pdf_other(wo, wi);
    }
    /// Whether another sampler may draw directions beside sample(). It may if evaluate() of without_bias() finds the
    /// light that sample() finds, and pdf() depends on the directions alone; pdf() need not be the density of sample().
    /// False for closures of plugins, which may be stochastic, and for coats over smooth metals (layered.h).
    [[nodiscard]] bool can_be_guided() const {
        if (const auto* coated = std::get_if<LayeredClosure<ConductorClosure>>(&closure_))
            return coated->base.has_density();
        return !holds<CustomClosure>();
    }
    /// Whether evaluate() has the bias of pbrt-v4's rough coats (layered.h), so that a change of the weights in
    /// multiple importance sampling changes the image.
    [[nodiscard]] bool is_biased() const {
        const auto* diffuse = std::get_if<LayeredClosure<LambertClosure>>(&closure_);
        const auto* metal = std::get_if<LayeredClosure<ConductorClosure>>(&closure_);
        const CoatLayer* coat = diffuse != nullptr ? &diffuse->coat : metal != nullptr ? &metal->coat : nullptr;
        return coat != nullptr && coat->as_pbrt && !coat->interface.facets.smooth();
    }
    /// Whether a change of the weights in multiple importance sampling changes the image: evaluate() is biased, or
    /// misses light that sample() finds, or pdf() may be stochastic.
    [[nodiscard]] bool depends_on_weights() const { return is_biased() || !can_be_guided(); }
    /// The same closure with values that are unbiased, and a pdf() whose integral is at most about 1.
    [[nodiscard]] Bsdf without_bias() const;
    /// Whether any lobe has a density: false means that light sampling is of no use here.
    [[nodiscard]] bool has_density() const { return has_density_; }
    /// Rough estimate of the directional albedo, for the albedo AOV.
    [[nodiscard]] Rgb albedo(const Vec3& wo) const;
    /// Refractive index on the inner side, 1 for surfaces that light does not enter.
    [[nodiscard]] Real inside_ior() const;

    template <class Closure>
    [[nodiscard]] bool holds() const {
        return std::holds_alternative<Closure>(closure_);
    }
    /// No surface: the integrator continues the ray in its direction, without an event. All other functions return what
    /// they return for BlackClosure.
    [[nodiscard]] bool passes_through() const { return holds<PassThroughClosure>(); }
    /// Whether sample() reads its u_lobe.
    [[nodiscard]] bool chooses_lobes() const { return chooses_lobes_; }
    [[nodiscard]] const Frame& frame() const { return frame_; }
    /// The lobes by side, for closures that choose between reflection and transmission first.
    [[nodiscard]] std::optional<SideLobes> side_lobes() const;
    /// From now on sample() always draws this side of side_lobes(), and densities are those of such samples; values of
    /// the other side may be missing. For camera subpaths.
    void keep_side(Sides side);

    /// Sets the index on the inner side of a dielectric interface to one of its IndexSpectrum.
    void set_index(Real inside);
    /// Whether the interface is ideal and passes, at every index of `indices`, some of the light from wo's side. The
    /// direction of reflected light then depends on no wavelength, and its amount is Fresnel's share.
    [[nodiscard]] bool reflects_all_alike(const IndexSpectrum& indices, const Vec3& wo) const;
    /// Where reflects_all_alike(): the reflectance at each colour's own index `inside`, over that at the interface's.
    [[nodiscard]] Rgb reflected_colours(const Rgb& inside, const Vec3& wo) const;

    /// Blurs microfacets (Ggx::regularized), smooth ones too: paths that begin to be hard to find become easier, and
    /// caustics softer. Closures of pbrt-v4 alone: those of raylex: materials have known answers and keep them.
    void regularize();

    // Setters, for materials. Each replaces the closure that was there. The caller prevents values that break the
    // closure's invariants (negative or NaN colours); materials clamp what textures return.

    void set_black() { set(BlackClosure{}); }
    void set_pass_through() { set(PassThroughClosure{}); }
    void set_phase(Real g) { set(PhaseClosure{g}); }
    /// A closure of the list. The s axis of the frame of hair runs along the fibre.
    template <class Closure>
    void set(const Frame& frame, const Closure& closure) {
        frame_ = frame;
        if constexpr (requires { closure.is_black(); })
            if (closure.is_black()) return set_black();
        set(closure);
    }
    /// A plugin's closure (custom_closure.h).
    template <ScatteringClosure Closure>
    void set_custom(const Frame& frame, const Closure& closure) {
        set(frame, CustomClosure(closure));
    }

  private:
    template <class Closure>
    void set(const Closure& closure) {
        closure_.emplace<Closure>(closure);
        has_density_ = closure.has_density();
        chooses_lobes_ = !WorldClosure<Closure>;
    }
    [[nodiscard]] BsdfEvaluation evaluate_other(const Vec3& wo, const Vec3& wi) const;
    [[nodiscard]] BsdfSample sample_other(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] Real pdf_other(const Vec3& wo, const Vec3& wi) const;
    /// Null for closures without a dielectric interface of their own.
    [[nodiscard]] const DielectricClosure* interface() const;
    template <class Edit>
    void edit(Edit&& edit_closure);

    Frame frame_;
    bool has_density_ = false;
    bool chooses_lobes_ = false;
    AnyClosure closure_;
};

}  // namespace raylex::transport
