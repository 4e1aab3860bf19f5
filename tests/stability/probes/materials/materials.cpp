#include "tests/stability/probes/materials/materials.h"

namespace raylex::experiments {
namespace {

using namespace transport;

/// A closure as a plugin could add it: half Lambert, half a lobe cos^n around the normal.
struct TwoCosines {
    Real exponent;

    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const {
        if (!(wo.z * wi.z > 0)) return 0;
        const Real c = std::abs(wi.z);
        return 0.5f * inv_pi * (c + 0.5f * (exponent + 1) * std::pow(c, exponent));
    }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        BsdfEvaluation result;
        result.pdf = pdf(wo, wi);
        if (!(result.pdf > 0)) return result;
        result.value = transport::Rgb(result.pdf);
        result.lobes.add(lobes::diffuse, result.value);
        return result;
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        BsdfSample s;
        s.wi = sample_cosine_hemisphere(u);
        if (u_lobe >= 0.5f) {
            const Real c = std::pow(1 - u.x, 1 / (exponent + 1)), sine = safe_sqrt((1 - c) * (1 + c)),
                       phi = 2 * transport::pi * u.y;
            s.wi = {sine * std::cos(phi), sine * std::sin(phi), c};
        }
        if (wo.z < 0) s.wi.z = -s.wi.z;
        s.pdf = pdf(wo, s.wi);
        s.weight = transport::Rgb(1);
        s.lobes.add(lobes::diffuse, transport::Rgb(s.pdf));
        return s;
    }
    [[nodiscard]] transport::Rgb albedo(Real) const { return transport::Rgb(1); }
    [[nodiscard]] bool has_density() const { return true; }
};

struct Chosen {
    Real alpha, alpha_y, eta, reflectance, coat_alpha, thickness, albedo, g;
    bool compensate;

    explicit Chosen(const ProbeInput& input) {
        const auto number = [&](const char* name, double fallback) {
            return static_cast<Real>(input.number(name, fallback));
        };
        alpha = number("alpha", 0.3);
        alpha_y = number("alpha_y", static_cast<double>(alpha));
        eta = number("eta", 1.5);
        reflectance = number("reflectance", 1);
        coat_alpha = number("coat_alpha", 0);
        thickness = std::max(number("thickness", 0.01), Real(1e-30));
        albedo = number("albedo", 0);
        g = number("g", 0);
        compensate = number("compensate", 0) != 0;
    }
    [[nodiscard]] Ggx facets() const { return Ggx::from_alpha(alpha, alpha_y); }
    [[nodiscard]] CoatLayer coat() const {
        return {{Ggx::from_alpha(coat_alpha, coat_alpha), eta}, thickness, g, transport::Rgb(albedo), 100, 1, false};
    }
    /// Facets of conductors and coats by the same name.
    [[nodiscard]] ConductorClosure conductor() const {
        return {facets(), transport::Rgb(reflectance), transport::Rgb(0), true};
    }
};

void set_glass(const Frame& frame, const Chosen& n, ProbedBsdf& result) {
    const DielectricClosure glass{n.facets(), n.eta};
    result.eta = static_cast<double>(n.eta);
    if (n.compensate && !glass.is_delta())
        result.bsdf.set(frame, CompensatedDielectric{glass, FacetAlbedo::shared(glass.facets, n.eta).get()});
    else result.bsdf.set(frame, GlassClosure{glass});
}

void set_metal(const Frame& frame, const Chosen& n, const ConductorClosure& metal, ProbedBsdf& result) {
    if (n.compensate && !metal.is_delta())
        result.bsdf.set(frame, CompensatedConductor{metal, FacetAlbedo::shared(metal.facets, 0).get()});
    else result.bsdf.set(frame, metal);
}

}  // namespace

Result<ProbedBsdf> probed_bsdf(const ProbeInput& input) {
    const std::string name = input.word("material");
    if (Status given = input.status(); !given) return given.error();
    const Chosen n(input);
    const Frame frame = Frame::from_normal_and_tangent(normalize({0.3f, -0.5f, 0.8f}), {0.6f, 0.7f, 0.1f});
    ProbedBsdf result;
    result.frame = frame;
    const bool facets = name == "conductor" || name == "metal" || name == "dielectric" || name == "additive";
    if (facets && !n.facets().smooth())
        result.width = std::min(static_cast<double>(std::min(n.facets().alpha_x, n.facets().alpha_y)), 1.0);
    if (name == "lambert") result.bsdf.set(frame, LambertClosure{transport::Rgb(n.reflectance)});
    else if (name == "conductor") set_metal(frame, n, n.conductor(), result);
    else if (name == "metal") set_metal(frame, n, {n.facets(), {0.2f, 0.92f, 1.1f}, {3.9f, 2.4f, 2.2f}, false}, result);
    else if (name == "dielectric") set_glass(frame, n, result);
    else if (name == "thindielectric") result.bsdf.set(frame, ThinDielectricClosure{n.eta});
    else if (name == "coateddiffuse")
        result.bsdf.set(frame, LayeredClosure<LambertClosure>{n.coat(), {transport::Rgb(n.reflectance)}, 7});
    else if (name == "coatedconductor")
        result.bsdf.set(frame, LayeredClosure<ConductorClosure>{n.coat(), n.conductor(), 7});
    else if (name == "additive")
        result.bsdf.set(frame,
                        AdditiveClosure{{transport::Rgb(0.4f * n.reflectance)},
                                        {n.facets(), transport::Rgb(0.6f * n.reflectance), transport::Rgb(0), true}});
    else if (name == "ideal")
        result.bsdf.set(frame, IdealClosure{transport::Rgb(0.5f * n.reflectance), transport::Rgb(0.3f * n.reflectance),
                                            transport::Rgb(0.2f * n.reflectance)});
    else if (name == "leaf")
        result.bsdf.set(frame, DiffuseTransmissionClosure{transport::Rgb(0.6f * n.reflectance),
                                                          transport::Rgb(0.4f * n.reflectance)});
    else if (name == "hair")
        result.bsdf.set(frame, transport::HairClosure({n.g, n.eta, transport::Rgb(1 - n.reflectance),
                                                       std::min(n.alpha, Real(1)), std::min(n.alpha_y, Real(1)), 2}));
    else if (name == "custom") result.bsdf.set_custom(frame, TwoCosines{20});
    else if (name == "phase") {
        result.bsdf.set_phase(n.g);
        result.about_wo = true;
        result.forward = n.g < 0 ? -1 : 1;
        result.width = 1 - std::abs(static_cast<double>(n.g));
    } else return error_at(input.where(), "unknown material '" + name + "'");
    return result;
}

Vec3 probed_direction(const ProbeInput& input) {
    const double mu = input.number("mu", 0.5), phi = input.number("phi", 0.7);
    const double sine = std::sqrt(std::max(0.0, (1 - mu) * (1 + mu)));
    return {static_cast<Real>(sine * std::cos(phi)), static_cast<Real>(sine * std::sin(phi)), static_cast<Real>(mu)};
}

}  // namespace raylex::experiments
