#include "transport/import/known_types.h"

#include <algorithm>
#include <initializer_list>

#include "transport/materials/material.h"

namespace raylex::transport {

namespace {

/// The types of parameters that have no registry entry, and of those that all types of a kind share.
std::optional<ParameterType> type_without_registry(EntityKind kind, const std::string& type, std::string_view name) {
    using T = ParameterType;
    const auto among = [&](std::initializer_list<std::string_view> names) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    switch (kind) {
        case EntityKind::film:
            if (among({"xresolution", "yresolution", "pixelbounds", "nbuckets"})) return T::integer;
            if (among({"cropwindow", "diagonal", "iso", "exposuretime", "whitebalance", "maxcomponentvalue",
                       "lambdamin", "lambdamax"}))
                return T::real;
            break;
        case EntityKind::camera:
            if (among(
                    {"shutteropen", "shutterclose", "frameaspectratio", "screenwindow", "lensradius", "focaldistance"}))
                return T::real;
            break;
        case EntityKind::shape:
            if (name == "alpha") return T::real;
            if (name == "S") return T::vector3;
            if (name == "faceIndices" || name == "splitdepth") return T::integer;
            break;
        case EntityKind::integrator:
            if (among({"maxdepth", "bootstrapsamples", "chains", "mutationsperpixel", "photonsperiteration", "seed"}))
                return T::integer;
            if (among({"largestepprobability", "sigma", "maxdistance", "radius"})) return T::real;
            break;
        case EntityKind::material:
            if (takes_normal_detail(type))
                for (const ParameterDescription& each : normal_detail_parameters())
                    if (each.name == name) return each.type;
            break;
        default:
            break;
    }
    return std::nullopt;
}

void become_grey(Parameter& parameter) {
    parameter.numbers.resize(3, parameter.numbers.front());
    parameter.type = ParameterType::rgb;
}

}  // namespace

std::optional<ParameterType> known_type(EntityKind kind, const std::string& type, std::string_view name) {
    if (const auto* entry = declared_parameters(kind, type); entry != nullptr)
        for (const ParameterDescription& each : *entry)
            if (each.name == name) return each.type;
    return type_without_registry(kind, type, name);
}

void use_known_types(EntityKind kind, const std::string& type, bool float_texture, ParameterSet& set) {
    using T = ParameterType;
    for (Parameter& parameter : set.parameters) {
        if (parameter.type != T::integer && parameter.type != T::real) continue;
        const std::optional<T> known = known_type(kind, type, parameter.name);
        if (!known || *known == parameter.type) continue;
        const bool texture = kind == EntityKind::texture;
        // pbrt's mix and scale textures read these as numbers, whatever they mix and scale.
        const bool factor = texture && (parameter.name == "amount" || parameter.name == "scale");
        const bool color = texture ? !float_texture && !factor && (*known == T::texture || *known == T::spectrum)
                                   : *known == T::rgb || *known == T::spectrum;
        const bool number = texture && !color && *known != T::integer;
        const bool bounded = texture || (kind == EntityKind::material && *known == T::rgb);
        const bool grey = color && parameter.numbers.size() == 1 && parameter.numbers.front() >= 0 &&
                          (!bounded || parameter.numbers.front() <= 1);
        if (grey) become_grey(parameter);
        else if (color || number || *known == T::real || *known == T::texture) parameter.type = T::real;
    }
}

}  // namespace raylex::transport
