// Makes media from pbrt-v4's MakeNamedMedium directives, with pbrt's parameters and defaults.
#include "transport/color/spectrum.h"
#include "transport/media/grid_media.h"
#include "transport/media/medium_parameters.h"

namespace raylex::transport {
namespace {

Result<Medium> make_homogeneous(const SceneMedium& entity, const MediumContext& context) {
    const ParameterSet& set = entity.parameters;
    auto coefficients = read_coefficients(entity, context);
    if (!coefficients) return coefficients.error();
    auto radiance = spectrum_or(set, "Le", Rgb(0), SpectrumRole::illuminant, context.scene.color);
    if (!radiance) return radiance.error();
    auto radiance_scale = set.real_or("Lescale", 1);
    if (!radiance_scale) return radiance_scale.error();
    auto g = read_asymmetry(entity, context);
    if (!g) return g.error();

    Medium medium;
    medium.sigma_a = coefficients->sigma_a;
    medium.sigma_s = coefficients->sigma_s;
    medium.sigma_t = medium.sigma_a + medium.sigma_s;
    medium.emission = medium.sigma_a * *radiance * static_cast<Real>(*radiance_scale);
    if (Status s = check_coefficients(medium.emission, "Le", entity); !s) return s.error();
    medium.g = *g;
    medium.grey = medium.sigma_t.r == medium.sigma_t.g && medium.sigma_t.g == medium.sigma_t.b;
    medium.scatters = !medium.sigma_s.is_black();
    medium.emits = !medium.emission.is_black();
    return medium;
}

}  // namespace

Registry<MediumFactory>& medium_registry() {
    static Registry<MediumFactory> registry = [] {
        using T = ParameterType;
        Registry<MediumFactory> r("medium");
        r.add({"homogeneous",
               "homogeneous, with Henyey-Greenstein scattering",
               {{"sigma_a", T::spectrum, "1", "absorption per unit length"},
                {"sigma_s", T::spectrum, "1", "scattering per unit length"},
                {"preset", T::string, "", "a measured medium's name, instead of both; per millimetre"},
                {"scale", T::real, "1", "factor on both"},
                {"g", T::real, "0", "asymmetry: -1 backward, 0 isotropic, 1 forward"},
                {"Le", T::spectrum, "0", "radiance of a thick layer that only absorbs; emission is sigma_a Le"},
                {"Lescale", T::real, "1", "factor on Le"}},
               make_homogeneous});
        register_grid_media(r);
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
