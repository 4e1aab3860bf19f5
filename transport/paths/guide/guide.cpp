#include "transport/paths/guide/guide.h"

#include <algorithm>
#include <optional>

#include "transport/paths/guide/guide_gains.h"

namespace raylex::transport {
namespace {

/// In both functions the same operations, so that sample() and pdf() agree to the bit.
Real mixed(Real share, Real by_guide, Real by_closure) {
    return share * by_guide + (1 - share) * by_closure;
}

/// A direction that the closure hardly draws has nearly no weight: no factor is larger.
Real favoured(Real pdf, Real closure_pdf) {
    constexpr Real most = 1000;
    return pdf < most * closure_pdf ? pdf / closure_pdf : most;
}

}  // namespace

std::uint32_t Guide::region_number(const SurfacePoint& point) const {
    if (point.direction_region > 0) return point.direction_region - 1;
    const bool surface = point.material != SurfacePoint::no_material;
    return tree_.place_of(point.position, surface ? point.shading_normal : Vec3{0, 0, 0}).region;
}

void Guide::locate(std::span<SurfacePoint> points) const {
    for (SurfacePoint& point : points) {
        point.direction_region = 0;
        point.direction_region = 1 + region_number(point);
    }
}

Real Guide::rays(const Bsdf& bsdf, const SurfacePoint& point, Real throughput) const {
    if (!bsdf.has_density()) return 1;
    return rays_by_gain(tree_.region(region_number(point)), throughput, training_);
}

/// The training takes all light samples: with fewer, they would weigh less, and seem to find less.
Real Guide::light_share(const SurfacePoint& point, Real throughput) const {
    return training_ ? Real(1) : light_share_by_gain(tree_.region(region_number(point)), throughput);
}

const GuideTree::Region* Guide::region_of(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode) const {
    if (mode == TransportMode::importance || !bsdf.can_be_guided()) return nullptr;
    const GuideTree::Region& region = tree_.region(region_number(point));
    return region.share > 0 ? &region : nullptr;
}

BsdfSample Guide::sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, Real u_lobe,
                         const Vec2& u) const {
    const GuideTree::Region* region = region_of(bsdf, point, mode);
    const Real share = region == nullptr ? Real(0) : region->share, rest = 1 - share;
    std::optional<Bsdf> without_bias;
    if (bsdf.is_biased()) without_bias = bsdf.without_bias();
    const Bsdf& closure = without_bias ? *without_bias : bsdf;
    // The weights of the mixture are functions of the direction alone. They sum to 1 even where the closure's pdf() is
    // not its density.
    BsdfSample s;
    Real closure_pdf = 0;
    if (u_lobe < share) {
        s.wi = tree_.sample(*region, u);
        const BsdfEvaluation f = closure.evaluate(point.wo, s.wi);
        if (f.value.is_black()) return s;
        closure_pdf = f.pdf;
        s.pdf = mixed(share, tree_.density(*region, s.wi), closure_pdf);
        s.weight = f.value * (1 / s.pdf);
        s.lobes = f.lobes;
    } else {
        if (share > 0) u_lobe = std::min((u_lobe - share) / rest, Real(1) - Real(0x1p-24));
        s = closure.sample(point.wo, u_lobe, u);
        if (!(s.pdf > 0)) return s;
        closure_pdf = s.pdf_is_proportional && !s.delta ? closure.pdf(point.wo, s.wi) : s.pdf;
        s.pdf = s.delta || share == 0 ? rest * closure_pdf : mixed(share, tree_.density(*region, s.wi), closure_pdf);
        s.weight *= closure_pdf / s.pdf;
    }
    s.favoured = favoured(s.pdf, closure_pdf);
    s.is_weighed = mode == TransportMode::radiance;
    if (without_bias && !s.delta) {
        const Real drawn_with = s.pdf;
        s.pdf = bsdf.pdf(point.wo, s.wi);
        s.drawn_over_pdf = drawn_with / s.pdf;
    }
    return s;
}

Real Guide::pdf(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, const Vec3& to,
                Real closure_pdf) const {
    const GuideTree::Region* region = region_of(bsdf, point, mode);
    // At biased closures the weights decide the mean, so they stay those without a guide.
    if (region == nullptr || bsdf.is_biased()) return closure_pdf;
    return mixed(region->share, tree_.density(*region, to), closure_pdf);
}

}  // namespace raylex::transport
