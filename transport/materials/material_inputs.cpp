#include "transport/materials/material_inputs.h"

#include <cmath>
#include <string>
#include <utility>

#include "transport/materials/metal_index.h"

namespace raylex::transport {

namespace {

/// Appended piece by piece: g++ 12 at -O3 wrongly warns of "literal" + string (-Wrestrict, GCC bug 105651).
std::string quoted(std::string_view prefix, std::string_view name) {
    std::string result(1, '"');
    result.append(prefix).append(name).append("\"");
    return result;
}

}  // namespace

bool RoughnessInput::may_be_smooth() const {
    const auto low = [this](const RealInput& i) {
        return i.varies || (remap ? safe_sqrt(i.value) : i.value) < Ggx::smooth_below;
    };
    return low(u) && low(v);
}

bool RoughnessInput::may_be_rough() const {
    const auto high = [this](const RealInput& i) {
        return i.varies || (remap ? safe_sqrt(i.value) : i.value) >= Ggx::smooth_below;
    };
    return high(u) || high(v);
}

std::optional<Ggx> RoughnessInput::constant() const {
    if (u.varies || v.varies) return std::nullopt;
    return remap ? Ggx::from_alpha(Ggx::alpha_from_roughness(u.value), Ggx::alpha_from_roughness(v.value))
                 : Ggx::from_alpha(u.value, v.value);
}

InterfaceLobes::InterfaceLobes(const RoughnessInput& roughness, Real eta, const IndexSpectrum* index) {
    const bool varies = index != nullptr;
    const bool matched = varies ? may_be_matched(*index) : DielectricClosure{{1, 1}, eta}.is_delta();
    rough = roughness.may_be_rough() && (!matched || varies);
    smooth = roughness.may_be_smooth() || matched;
    smooth_reflection = smooth && (eta != 1 || varies);
}

ConductorClosure ConductorInput::at(const TextureTable& textures, const SurfacePoint& p, Real outside_eta) const {
    ConductorClosure closure;
    closure.facets = roughness.at(textures, p);
    closure.eta = by_reflectance ? Rgb(1) : eta.at(textures, p);
    closure.k = by_reflectance ? conductor_k_from_reflectance(reflectance.at(textures, p)) : k.at(textures, p);
    closure.constant_reflectance = false;
    if (outside_eta != 1) {
        closure.eta *= 1 / outside_eta;
        closure.k *= 1 / outside_eta;
    }
    return closure;
}

MaterialReader::MaterialReader(const SceneEntity& entity, const MaterialContext& context)
    : ParameterReader(entity.parameters), entity_(entity), context_(context) {
    static_cast<void>(set().find("type"));  // how MakeNamedMaterial names it
}

TextureId MaterialReader::looked_up(TextureId constant) const {
    return context_.scene.general_code.contains(Effect::image_textures) ? constant : -1;
}

RgbInput MaterialReader::rgb(std::string_view name, const Rgb& fallback, SpectrumRole role) {
    const TextureId id =
        take(context_.textures.rgb_parameter(set(), name, fallback, role, context_.scene.color), TextureId{-1});
    if (id < 0) return {fallback, -1};
    if (context_.textures.is_constant(id)) return {context_.textures.rgb(id, {}), looked_up(id), false};
    return {fallback, id, true};
}

RealInput MaterialReader::real_texture(std::string_view name, Real fallback) {
    const TextureId id = take(context_.textures.real_parameter(set(), name, fallback), TextureId{-1});
    if (id < 0) return {fallback, -1};
    if (context_.textures.is_constant(id)) return {context_.textures.real(id, {}), looked_up(id), false};
    return {fallback, id, true};
}

RoughnessInput MaterialReader::roughness(std::string_view prefix, Real fallback) {
    const std::string p(prefix);
    RoughnessInput result;
    const RealInput both = real_texture(p + "roughness", fallback);
    result.u = set().find(p + "uroughness") != nullptr ? real_texture(p + "uroughness", fallback) : both;
    result.v = set().find(p + "vroughness") != nullptr ? real_texture(p + "vroughness", fallback) : both;
    result.remap = boolean("remaproughness", true);
    bool said = false;
    for (RealInput* each : {&result.u, &result.v}) {
        if (each->varies || each->value >= 0) continue;
        Error negative = error_at(
            entity_.location, quoted(p, "roughness") + " is " + std::to_string(each->value) + "; expected 0 or more");
        if (result.remap || std::isnan(each->value)) {  // pbrt-v4 takes this root too, which is NaN
            fail(std::move(negative));
            continue;
        }
        negative.message += ", and it is taken as 0";
        if (!said) context_.textures.warn(std::move(negative));
        said = true;
        each->value = 0;
    }
    return result;
}

RgbInput MaterialReader::metal_parameter(std::string_view name, std::string_view fallback) {
    if (set().find(name) != nullptr) return rgb(name, Rgb(1), SpectrumRole::unbounded);
    return {take(resolve_named_spectrum(fallback, SpectrumRole::unbounded, context_.scene.color), Rgb(1)), -1};
}

std::optional<VisibleSpectrum> MaterialReader::metal_spectrum(std::string_view name, std::string_view fallback,
                                                              const RgbInput& read) {
    VisibleSpectrum spectrum{};
    const Parameter* parameter = set().find(name);
    if (parameter == nullptr) {
        find_named_spectrum(fallback, spectrum);
        return spectrum;
    }
    if (read.varies || error()) return std::nullopt;
    if (auto varies = take(varying_spectrum(*parameter), std::optional<VisibleSpectrum>())) return varies;
    if (read.value != Rgb(read.value.r)) return std::nullopt;
    spectrum.fill(read.value.r);
    return spectrum;
}

ConductorInput MaterialReader::conductor(std::string_view prefix, Real outside) {
    const std::string p(prefix);
    ConductorInput result;
    result.roughness = roughness(prefix, 0);
    if (set().find("reflectance") != nullptr) {
        for (const char* other : {"eta", "k"})
            if (const Parameter* both = set().find(p + other); both != nullptr)
                fail(error_at(where(*both), quoted("", "reflectance") + " and " + quoted(p, other) +
                                                " are both given; expected only one of them"));
        result.by_reflectance = true;
        result.reflectance = rgb("reflectance", Rgb(0));
        return result;
    }
    result.eta = metal_parameter(p + "eta", "metal-Cu-eta");
    result.k = metal_parameter(p + "k", "metal-Cu-k");
    const auto eta = metal_spectrum(p + "eta", "metal-Cu-eta", result.eta),
               k = metal_spectrum(p + "k", "metal-Cu-k", result.k);
    const auto varies = [](const RgbInput& input) { return input.value != Rgb(input.value.r); };
    if (eta && k && (varies(result.eta) || varies(result.k))) {
        const MetalIndex index =
            rgb_index_of_metal(*eta, *k, {result.eta.value, result.k.value}, outside, context_.scene.color);
        result.eta = {index.eta, -1};
        result.k = {index.k, -1};
    }
    return result;
}

std::shared_ptr<const FacetAlbedo> MaterialReader::compensation(const RoughnessInput& roughness, Real eta) {
    if (!boolean("raylex:compensate", false) || error()) return nullptr;
    const std::optional<Ggx> facets = roughness.constant();
    if (!facets && !roughness.isotropic()) {
        fail(error_at(where(*set().find("raylex:compensate")),
                      "\"raylex:compensate\" with a texture for one of two roughnesses is not supported; expected "
                      "numbers for \"uroughness\" and \"vroughness\", or one texture for both"));
        return nullptr;
    }
    const bool smooth = (facets && facets->smooth()) || (eta > 0 && DielectricClosure{{1, 1}, eta}.is_delta());
    return smooth ? nullptr : FacetAlbedo::shared(facets, eta);
}

Real MaterialReader::index_of_refraction(std::string_view name, Real fallback) {
    const Parameter* parameter = set().find(name);
    if (parameter == nullptr) return fallback;
    if (parameter->type == ParameterType::texture) {
        fail(error_at(where(*parameter), quoted("", name) + " must be a number or a spectrum, not a texture"));
        return fallback;
    }
    const Real eta = take(mean_of_spectrum(*parameter, context_.scene.color), fallback);
    if (eta == 0) return 1;  // as pbrt-v4: no index given means no interface
    if (eta > 0 && eta < 100) return eta;
    fail(error_at(where(*parameter), quoted("", name) + " is " + std::to_string(eta) +
                                         "; expected an index of refraction above 0 (glass: 1.5)"));
    return fallback;
}

std::shared_ptr<const IndexSpectrum> MaterialReader::index_spectrum(std::string_view name) {
    const Parameter* parameter = set().find(name);
    if (parameter == nullptr || error()) return nullptr;
    const auto spectrum = take(varying_spectrum(*parameter), std::optional<VisibleSpectrum>());
    if (!spectrum) return nullptr;
    auto index = std::make_shared<const IndexSpectrum>(*spectrum, context_.scene.color);
    if (index->least() > 0 && index->most() < 100) return index;
    fail(error_at(where(*parameter), quoted("", name) + " has values from " + std::to_string(index->least()) + " to " +
                                         std::to_string(index->most()) +
                                         "; expected indices of refraction above 0 (glass: 1.5)"));
    return nullptr;
}

}  // namespace raylex::transport
