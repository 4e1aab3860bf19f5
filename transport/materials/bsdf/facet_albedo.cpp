#include "transport/materials/bsdf/facet_albedo.h"

#include <array>
#include <map>
#include <mutex>

#include "display/services/elementary.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {

namespace {

/// Where E is tabulated: x in [0, 1] with mu = w x^2 / (1 + w - x^2). Towards grazing angles E changes over cosines of
/// about alpha, and steeply at 0: w is 4 alpha, alpha half that along wo's azimuth (x, y), half the larger one.
Real width_of(const Ggx& facets, Real x, Real y) {
    if (facets.alpha_x == facets.alpha_y) return 4 * facets.alpha_x;
    const Real l2 = x * x + y * y;
    const Real along = l2 > 0 ? std::sqrt((square(facets.alpha_x * x) + square(facets.alpha_y * y)) / l2) : 0.0f;
    return 2 * (along + std::max(facets.alpha_x, facets.alpha_y));
}

Real step(int i, int count) {
    return count > 1 ? static_cast<Real>(i) / static_cast<Real>(count - 1) : 0.0f;
}

Vec3 direction_at(const Ggx& facets, Real x, Real azimuth) {
    const Real along = azimuth, across = 1 - azimuth, scale = 1 / elementary::hypot(along, across);
    const Real w = width_of(facets, along, across);
    const Real mu = std::clamp(w * x * x / (1 + w - x * x), 2 * min_cosine, Real(1));
    const Real sine = safe_sqrt((1 - mu) * (1 + mu)) * scale;
    return {along * sine, across * sine, mu};
}

/// The light that one visible normal returns: Fresnel's shares of the reflected and refracted directions, masked.
double given_back(const Ggx& facets, const Vec3& wo, const Vec3& m, Real eta, double lambda_o) {
    const Real om = dot(wo, m);
    if (!(om > 0)) return 0;
    const auto masked = [&](const Vec3& wi) {
        return (1 + lambda_o) / (1 + lambda_o + static_cast<double>(facets.lambda(wi)));
    };
    const Real fresnel = eta > 0 ? fresnel_dielectric(om, eta) : 1.0f;
    const Vec3 reflected = reflect(wo, m);
    double sum = reflected.z >= min_cosine ? static_cast<double>(fresnel) * masked(reflected) : 0;
    if (fresnel < 1) {
        const Real cos_t = std::sqrt(refracted_cosine_squared(om, eta));
        const Vec3 refracted = wo / eta - m * (om / eta - cos_t);  // mirrored up
        if (refracted.z >= min_cosine) sum += (1 - static_cast<double>(fresnel)) * masked(refracted);
    }
    return sum;
}

/// Position of `v` in [0, 1] among `count` nodes: the lower one, and how far past it.
struct Between {
    std::size_t lower;
    Real rest;

    Between(Real v, int count) {
        const Real scaled = std::clamp(v, Real(0), Real(1)) * static_cast<Real>(count - 1);
        lower = std::min(static_cast<std::size_t>(scaled), static_cast<std::size_t>(std::max(count - 2, 0)));
        rest = count > 1 ? scaled - static_cast<Real>(lower) : 0.0f;
    }
};

}  // namespace

double FacetAlbedo::integrate(const Ggx& facets, const Vec3& wo, Real eta, int points) {
    const auto lambda_o = static_cast<double>(facets.lambda(wo));
    double sum = 0, a = 0.5, b = 0.5;
    for (int i = 0; i < points; ++i) {
        const Vec2 u{static_cast<Real>(a * a * (3 - 2 * a)), static_cast<Real>(b)};
        sum += 6 * a * (1 - a) * given_back(facets, wo, facets.sample_visible_normal(wo, u), eta, lambda_o);
        a += 0.7548776662466927;  // 1 / 1.3247..., the root of x^3 = x + 1
        b += 0.5698402909980532;
        a -= a >= 1 ? 1 : 0;
        b -= b >= 1 ? 1 : 0;
    }
    return std::min(sum / points, 1.0);
}

FacetAlbedo::FacetAlbedo(const std::optional<Ggx>& only, Real eta) : cosines_(64), glass_(eta > 0) {
    if (!only) alphas_ = 33;
    else if (only->alpha_x != only->alpha_y) azimuths_ = 17;
    else cosines_ = 128;
    const int points = rows() == 1 ? 4096 : 2048;
    for (int side = 0; side < (glass_ ? 2 : 1); ++side)
        for (int r = 0; r < static_cast<int>(rows()); ++r) {
            // Even steps in alpha / (1 + alpha) reach from ideal facets to any roughness.
            const Real a = step(r, alphas_), alpha = std::clamp(a / (1 - a), Ggx::smooth_below, Real(1e3));
            const Ggx facets = only ? *only : Ggx{alpha, alpha};
            const Real azimuth = azimuths_ > 1 ? step(r, azimuths_) : 1.0f;
            for (int i = 0; i < cosines_; ++i)
                table_.push_back(static_cast<float>(integrate(facets, direction_at(facets, step(i, cosines_), azimuth),
                                                              side == 0 ? eta : 1 / eta, points)));
        }
}

Real FacetAlbedo::along_cosine(std::size_t row, Real x) const {
    const Between at(x, cosines_);
    const float* values = table_.data() + row * static_cast<std::size_t>(cosines_) + at.lower;
    return lerp(at.rest, values[0], values[1]);
}

Real FacetAlbedo::operator()(const Ggx& facets, const Vec3& wo) const {
    const Real mu = std::abs(wo.z), w = width_of(facets, wo.x, wo.y);
    const Real x = std::sqrt(mu * (1 + w) / (mu + w));
    const std::size_t side = glass_ && wo.z < 0 ? rows() : 0;
    if (rows() == 1) return along_cosine(side, x);
    const Real along = std::abs(wo.x), sum = along + std::abs(wo.y);
    const Between at = azimuths_ > 1 ? Between(sum > 0 ? along / sum : 0.5f, azimuths_)
                                     : Between(facets.alpha_x / (1 + facets.alpha_x), alphas_);
    return lerp(at.rest, along_cosine(side + at.lower, x), along_cosine(side + at.lower + 1, x));
}

std::shared_ptr<const FacetAlbedo> FacetAlbedo::shared(const std::optional<Ggx>& only, Real eta) {
    static std::mutex mutex;
    static std::map<std::array<Real, 3>, std::shared_ptr<const FacetAlbedo>> known;
    const std::array<Real, 3> key{only ? only->alpha_x : 0, only ? only->alpha_y : 0, eta};
    const std::lock_guard lock(mutex);
    std::shared_ptr<const FacetAlbedo>& entry = known[key];
    if (!entry) entry = std::make_shared<const FacetAlbedo>(only, eta);
    return entry;
}

}  // namespace raylex::transport
