// hair: fibres, with v across and dpdu along them.
#include "transport/materials/closures/hair.h"

#include <limits>

#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

/// The parameter that decides the absorption. The first one that is given wins, as in pbrt-v4.
enum class HairColour : std::uint8_t { absorption, reflectance, melanin };

struct HairInput {
    HairColour by = HairColour::melanin;
    RgbInput colour;  ///< absorption or reflectance
    RealInput eumelanin, pheomelanin, eta, beta_m, beta_n, alpha;

    [[nodiscard]] Rgb absorption(const TextureTable& textures, const SurfacePoint& p, Real beta_n_here) const {
        const auto positive = [](Real x) { return std::max(x, Real(0)); };
        if (by == HairColour::melanin)
            return hair_absorption_of_melanin(positive(eumelanin.at(textures, p)),
                                              positive(pheomelanin.at(textures, p)));
        const Rgb c = colour.at(textures, p);
        if (by == HairColour::reflectance) return hair_absorption_of_reflectance(clamp_to_unit(c), beta_n_here);
        return {positive(c.r), positive(c.g), positive(c.b)};
    }
    [[nodiscard]] HairClosure at(const TextureTable& textures, const SurfacePoint& p) const {
        HairParameters hair;
        hair.h = (2 * p.v - 1) * (p.mirrored ? -1 : 1);  // the closure's frame is right-handed in the world
        // A fibre of index 1 or less is not meant: it would reflect totally outside.
        hair.eta = std::clamp(eta.at(textures, p), Real(1.0001), Real(100));
        hair.beta_m = beta_m.at(textures, p);
        hair.beta_n = std::clamp(beta_n.at(textures, p), Real(0), Real(1));
        hair.alpha = alpha.at(textures, p);
        hair.sigma_a = absorption(textures, p, hair.beta_n);
        return HairClosure(hair);
    }
};

MadeMaterial make_hair(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    HairInput input;
    const auto given = [&](const char* name) { return reader.set().find(name) != nullptr; };
    // find() marks a parameter as known, also one that has no effect here.
    const bool absorption = given("sigma_a"), reflectance = given("reflectance"), colour = given("color"),
               eumelanin = given("eumelanin"), pheomelanin = given("pheomelanin");
    if (absorption) {
        input.by = HairColour::absorption;
        input.colour = reader.rgb("sigma_a", Rgb(0), SpectrumRole::unbounded);
    } else if (reflectance || colour) {
        input.by = HairColour::reflectance;
        input.colour = reader.rgb(reflectance ? "reflectance" : "color", Rgb(0));
    } else {
        input.eumelanin = reader.real_texture("eumelanin", pheomelanin && !eumelanin ? Real(0) : Real(1.3));
        input.pheomelanin = reader.real_texture("pheomelanin", 0);
    }
    input.eta = reader.real_texture("eta", Real(1.55));
    input.beta_m = reader.real_texture("beta_m", Real(0.3));
    input.beta_n = reader.real_texture("beta_n", Real(0.3));
    input.alpha = reader.real_texture("alpha", 2);
    for (const RealInput* each : {&input.beta_m, &input.beta_n})
        if (!each->varies && !(each->value >= 0 && each->value <= 1))  // the closure clamps it, as pbrt-v4 does
            context.textures.warn(error_at(entity.location, "hair's roughness beta_m or beta_n is " +
                                                                std::to_string(each->value) +
                                                                "; expected 0 to 1, and the nearer of them is taken"));
    if (input.eta.texture < 0 && !(input.eta.value > 1))
        reader.fail(error_at(entity.location, "hair's index \"eta\" is " + std::to_string(input.eta.value) +
                                                  "; expected more than 1 (hair: 1.55)"));
    return reader.material({lobes::hair_r, lobes::hair_tt, lobes::hair_trt, lobes::hair_trrt},
                           [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
                               closure.set(Frame::from_normal_and_tangent(p.shading_normal, p.dpdu),
                                           input.at(textures, p));
                           });
}

}  // namespace

void register_hair_materials(Registry<MaterialFactory>& registry) {
    using enum ParameterType;
    registry.add({"hair",
                  "fibres (Chiang et al. 2016); v across, dp/du along them",
                  {{"sigma_a", spectrum, "", "absorption per fibre radius; wins over the other colours"},
                   {"reflectance", rgb, "", "colour of dense hair; wins over melanin"},
                   {"color", rgb, "", "as reflectance"},
                   {"eumelanin", real, "1.3", "concentration of brown pigment; 0 where only pheomelanin is given"},
                   {"pheomelanin", real, "0", "concentration of red pigment"},
                   {"eta", real, "1.55", "index of refraction"},
                   {"beta_m", real, "0.3", "roughness along the fibre, 0 to 1"},
                   {"beta_n", real, "0.3", "roughness around the fibre, 0 to 1"},
                   {"alpha", real, "2", "angle of the scales, degrees"}},
                  make_hair});
}

}  // namespace raylex::transport
