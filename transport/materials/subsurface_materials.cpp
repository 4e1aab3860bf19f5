// subsurface: a dielectric interface over a homogeneous medium, in which light walks at random.
//
// pbrt-v4 spreads light by a tabulated diffusion profile between points of the surface; here light walks through the
// shape, as with a dielectric and a MediumInterface under volpath. All of pbrt's ways to give coefficients are read.
#include <string>
#include <utility>

#include "transport/materials/material_inputs.h"
#include "transport/media/medium_parameters.h"
#include "transport/media/subsurface.h"

namespace raylex::transport {

namespace {

class SubsurfaceMaterial final : public Material {
  public:
    SubsurfaceMaterial(const RoughnessInput& roughness, Real eta, const Medium& interior,
                       std::shared_ptr<const IndexSpectrum> index)
        : roughness_(roughness), eta_(eta), interior_(interior) {
        index_spectrum = std::move(index);
    }
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const DielectricClosure border{roughness_.at(textures, points[i]), eta_};
            closures[i].set(shading_frame(points[i], border.facets), GlassClosure{border, true});
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        const InterfaceLobes may_give(roughness_, eta_, index_spectrum.get());
        if (may_give.rough) lobes.push_back(lobes::specular_glossy);
        if (may_give.smooth_reflection) lobes.push_back(lobes::specular_singular);
        lobes.push_back(lobes::subsurface);
    }
    const Medium* interior() const override { return &interior_; }

  private:
    RoughnessInput roughness_;
    Real eta_;
    Medium interior_;
};

/// Reads one value for the whole medium. A texture counts by its mean over u and v from 0 to 1, with a warning.
class UniformReader {
  public:
    UniformReader(MaterialReader& reader, TextureTable& textures) : reader_(reader), textures_(textures) {}

    Rgb rgb(const char* name, const Rgb& fallback, SpectrumRole role) {
        const RgbInput input = reader_.rgb(name, fallback, role);
        if (!input.varies) return input.value;
        textures_.warn(error_at(reader_.where(*reader_.set().find(name)),
                                std::string("the texture for '") + name +
                                    "' of a subsurface material is taken at its mean: the medium is homogeneous"));
        constexpr int side = 64;
        Rgb sum;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                TexturePoint at;
                at.u = (static_cast<Real>(x) + Real(0.5)) / side;
                at.v = (static_cast<Real>(y) + Real(0.5)) / side;
                sum += textures_.rgb(input.texture, at);
            }
        return sum * (1 / Real(side * side));
    }

  private:
    MaterialReader& reader_;
    TextureTable& textures_;
};

Parameter coefficient(const char* name, const Rgb& value) {
    Parameter p;
    p.name = name;
    p.type = ParameterType::rgb;
    for (int c = 0; c < 3; ++c) p.numbers.push_back(static_cast<double>(value[c]));
    return p;
}

/// Makes the medium from the parameters that a scene would give, so that the medium's factory checks them.
Result<Medium> make_interior(const SceneEntity& entity, const MaterialContext& context, MaterialReader& reader,
                             Real eta) {
    SceneMedium medium;
    medium.name = entity.name.empty() ? "subsurface" : entity.name;
    medium.type = "homogeneous";
    medium.location = medium.parameters.location = entity.location;
    std::vector<Parameter>& parameters = medium.parameters.parameters;
    UniformReader uniform(reader, context.textures);
    const ParameterSet& set = reader.set();
    const Parameter *name = set.find("name"), *reflectance = set.find("reflectance"), *g = set.find("g"),
                    *scale = set.find("scale");
    const bool coefficients = set.find("sigma_a") != nullptr || set.find("sigma_s") != nullptr;
    static_cast<void>(set.find("mfp"));
    if (name != nullptr) {
        // Unlike a medium's preset, pbrt-v4 refuses a name that it does not know.
        const std::string called = reader.string("name", "");
        if (!called.empty())
            if (auto known = measured_coefficients(called, reader.where(*name)); !known) return known.error();
        parameters.push_back(*name);
        parameters.back().name = "preset";
    } else if (reflectance != nullptr && !coefficients) {
        const Rgb albedo = scattering_albedo_of_reflectance(
            uniform.rgb("reflectance", Rgb(1), SpectrumRole::albedo), static_cast<double>(eta),
            static_cast<double>(reader.real("g", 0, Real(-0.999), Real(0.999))));
        // pbrt-v4 scales the mean free path here, not the coefficients.
        const Rgb mfp = uniform.rgb("mfp", Rgb(1), SpectrumRole::unbounded) * reader.real("scale", 1);
        scale = nullptr;
        Rgb sigma_a, sigma_s;
        for (int c = 0; c < 3; ++c) {
            if (!(mfp[c] > 0))
                return error_at(entity.location, "'mfp' times 'scale' is " + std::to_string(mfp[c]) +
                                                     "; expected a mean free path above 0 in every colour");
            sigma_s[c] = albedo[c] / mfp[c];
            sigma_a[c] = (1 - albedo[c]) / mfp[c];
        }
        parameters = {coefficient("sigma_a", sigma_a), coefficient("sigma_s", sigma_s)};
    } else {
        // Whole milk, per millimetre (Jensen et al. 2001).
        parameters = {coefficient("sigma_a", uniform.rgb("sigma_a", {Real(.0011), Real(.0024), Real(.014)},
                                                         SpectrumRole::unbounded)),
                      coefficient("sigma_s", uniform.rgb("sigma_s", {Real(2.55), Real(3.21), Real(3.77)},
                                                         SpectrumRole::unbounded))};
    }
    if (scale != nullptr) parameters.push_back(*scale);
    if (g != nullptr && name == nullptr) parameters.push_back(*g);  // presets hold reduced scattering coefficients
    auto entry = medium_registry().require(medium.type, medium.location);
    if (!entry) return entry.error();
    std::vector<Error> warnings;
    auto made = (*entry)->factory(medium, {context.scene, nullptr, warnings});
    for (Error& warning : warnings) context.textures.warn(std::move(warning));
    if (made) made->in_body = true;
    return made;
}

MadeMaterial make_subsurface(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RoughnessInput roughness = reader.roughness("", 0);
    const Real eta = reader.index_of_refraction("eta", Real(1.33));
    auto index = reader.index_spectrum("eta");
    if (reader.error()) return *reader.error();
    const Result<Medium> interior = make_interior(entity, context, reader, eta);
    if (reader.error()) return *reader.error();
    if (!interior) return interior.error();
    return std::unique_ptr<Material>(std::make_unique<SubsurfaceMaterial>(roughness, eta, *interior, std::move(index)));
}

}  // namespace

void register_subsurface_materials(Registry<MaterialFactory>& registry) {
    using enum ParameterType;
    registry.add({"subsurface",
                  "a dielectric over a medium in which light walks at random",
                  {{"name", string, "", "a measured medium's name, instead of coefficients; per millimetre"},
                   {"sigma_a", spectrum, "0.0011 0.0024 0.014", "absorption per unit length"},
                   {"sigma_s", spectrum, "2.55 3.21 3.77", "scattering per unit length"},
                   {"reflectance", rgb, "", "diffuse reflectance, instead of coefficients"},
                   {"mfp", spectrum, "1", "mean free path, with reflectance"},
                   {"scale", real, "1", "factor on coefficients"},
                   {"g", real, "0", "asymmetry: -1 back, 0 all ways, 1 on"},
                   {"eta", real, "1.33", "index of refraction, inside over outside"},
                   {"roughness", real, "0", "facets on both axes; 0 is smooth"},
                   {"uroughness", real, "roughness", "along dp/du"},
                   {"vroughness", real, "roughness", "across dp/du"},
                   {"remaproughness", boolean, "true", "alpha = sqrt(roughness) instead of roughness"}},
                  make_subsurface});
}

}  // namespace raylex::transport
