#include "transport/paths/guide/guide.h"

#include <algorithm>

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
    const bool surface = point.material != SurfacePoint::no_material;
    return tree_.place_of(point.position, surface ? point.shading_normal : Vec3{0, 0, 0}).region;
}

void Guide::locate(std::span<SurfacePoint> points) const {
    for (SurfacePoint& point : points) point.direction_region = 1 + region_number(point);
}

Real Guide::rays(const Bsdf& bsdf, const SurfacePoint& point, Real throughput) const {
    if (!bsdf.has_density()) return 1;
    const std::uint32_t number = point.direction_region > 0 ? point.direction_region - 1 : region_number(point);
    return rays_by_gain(tree_.region(number), throughput);
}

const GuideTree::Region* Guide::region_of(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode) const {
    if (mode == TransportMode::importance || !bsdf.pdf_is_exact()) return nullptr;
    const std::uint32_t number = point.direction_region > 0 ? point.direction_region - 1 : region_number(point);
    const GuideTree::Region& region = tree_.region(number);
    return region.share > 0 ? &region : nullptr;
}

BsdfSample Guide::sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, Real u_lobe,
                         const Vec2& u) const {
    const GuideTree::Region* region = region_of(bsdf, point, mode);
    if (region == nullptr) {
        BsdfSample s = bsdf.sample(point.wo, u_lobe, u);
        if (s.pdf_is_proportional && !s.delta && s.pdf > 0) s.pdf = bsdf.pdf(point.wo, s.wi);
        s.is_weighed = mode == TransportMode::radiance;
        return s;
    }
    const Real share = region->share, rest = 1 - share;
    if (u_lobe < share) {
        BsdfSample s;
        s.wi = tree_.sample(*region, u);
        const BsdfEvaluation f = bsdf.evaluate(point.wo, s.wi);
        if (f.value.is_black()) return s;
        s.pdf = mixed(share, tree_.density(*region, s.wi), f.pdf);
        s.weight = f.value * (1 / s.pdf);
        s.favoured = favoured(s.pdf, f.pdf);
        s.lobes = f.lobes;
        s.is_weighed = true;
        return s;
    }
    BsdfSample s = bsdf.sample(point.wo, std::min((u_lobe - share) / rest, Real(1) - Real(0x1p-24)), u);
    if (!(s.pdf > 0)) return s;
    const Real closure_pdf = s.pdf;
    s.pdf = s.delta ? rest * closure_pdf : mixed(share, tree_.density(*region, s.wi), closure_pdf);
    s.weight *= closure_pdf / s.pdf;
    s.favoured = favoured(s.pdf, closure_pdf);
    s.is_weighed = true;
    return s;
}

Real Guide::pdf(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, const Vec3& to,
                Real closure_pdf) const {
    const GuideTree::Region* region = region_of(bsdf, point, mode);
    return region == nullptr ? closure_pdf : mixed(region->share, tree_.density(*region, to), closure_pdf);
}

}  // namespace raylex::transport
