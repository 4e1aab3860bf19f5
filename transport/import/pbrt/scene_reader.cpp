#include "transport/import/pbrt/scene_reader.h"

#include <algorithm>
#include <cctype>

#include "lpe/input/budgets.h"
#include "transport/color/color_space.h"

namespace raylex::transport {

namespace {

enum class Where : std::uint8_t { anywhere, before_world, in_world };

Where allowed_where(DirectiveId id) {
    switch (id) {
        case DirectiveId::accelerator:
        case DirectiveId::camera:
        case DirectiveId::film:
        case DirectiveId::integrator:
        case DirectiveId::pixel_filter:
        case DirectiveId::sampler:
        case DirectiveId::transform_times:
        case DirectiveId::world_begin:
            return Where::before_world;
        case DirectiveId::area_light_source:
        case DirectiveId::attribute_begin:
        case DirectiveId::attribute_end:
        case DirectiveId::import:
        case DirectiveId::light_source:
        case DirectiveId::make_named_material:
        case DirectiveId::material:
        case DirectiveId::named_material:
        case DirectiveId::object_begin:
        case DirectiveId::object_end:
        case DirectiveId::object_instance:
        case DirectiveId::reverse_orientation:
        case DirectiveId::shape:
        case DirectiveId::texture:
        case DirectiveId::transform_begin:
        case DirectiveId::transform_end:
            return Where::in_world;
        default:
            return Where::anywhere;
    }
}

// pbrt's spellings; letter case is ignored.
constexpr struct {
    const char* name;
    ColorSpace space;
} space_names[] = {{"srgb", ColorSpace::srgb},
                   {"dci-p3", ColorSpace::dci_p3},
                   {"rec2020", ColorSpace::rec2020},
                   {"aces2065-1", ColorSpace::aces2065_1}};

}  // namespace

Status SceneReader::apply(Directive& directive) {
    if (Status status = require_block(directive); !status) return status;
    for (Error& warning : directive.warnings) scene_.warn(std::move(warning));
    switch (directive.id) {
        case DirectiveId::transform_times:
            return scene_.set_transform_times(directive.numbers[0], directive.numbers[1], directive.location);
        case DirectiveId::include:
        case DirectiveId::import:
            return success();
        case DirectiveId::attribute_begin:
        case DirectiveId::transform_begin:
            return begin_block(Block::attribute, directive.location);
        case DirectiveId::attribute_end:
        case DirectiveId::transform_end:
            return end_block(Block::attribute, directive);
        case DirectiveId::object_end:
            return end_block(Block::object, directive);
        case DirectiveId::world_begin:
            return world_begin(directive);
        case DirectiveId::color_space:
            return color_space(directive);
        case DirectiveId::attribute:
            return attribute(directive);
        case DirectiveId::option:
            return option(directive);
        case DirectiveId::reverse_orientation:
            state_.reverse_orientation = !state_.reverse_orientation;
            return success();
        case DirectiveId::medium_interface:
            return medium_interface(directive);
        case DirectiveId::make_named_medium:
            return named_medium(directive);
        case DirectiveId::camera:
            return camera(directive);
        case DirectiveId::film:
        case DirectiveId::integrator:
        case DirectiveId::pixel_filter:
        case DirectiveId::sampler:
            return settings(directive);
        case DirectiveId::accelerator:
            return accelerator(directive);
        case DirectiveId::active_transform:
            return active_transform(directive);
        case DirectiveId::identity:
        case DirectiveId::translate:
        case DirectiveId::scale:
        case DirectiveId::rotate:
        case DirectiveId::look_at:
        case DirectiveId::transform:
        case DirectiveId::concat_transform:
        case DirectiveId::coordinate_system:
        case DirectiveId::coord_sys_transform:
            return transform(directive);
        default:
            return world_entity(directive);
    }
}

Status SceneReader::require_block(const Directive& directive) const {
    const Where where = allowed_where(directive.id);
    const std::string name(directive.name);
    if (where == Where::before_world && in_world_)
        return error_at(directive.location, name + " after WorldBegin; expected it before");
    if (where == Where::in_world && !in_world_)
        return error_at(directive.location, name + " before WorldBegin; expected it after");
    return success();
}

Status SceneReader::begin_block(Block block, const SourceLocation& where) {
    if (stack_.size() >= budget(Budget::block_depth))
        return over_budget(Budget::block_depth, "blocks inside one another too deep", where.file, where.line,
                           where.column);
    stack_.push_back({block, state_, where, {}});
    return success();
}

Status SceneReader::end_block(Block block, const Directive& directive) {
    const bool matches = !stack_.empty() && stack_.back().block == block;
    if (!matches && block == Block::attribute && (stack_.empty() || stack_.back().block == Block::import)) {
        scene_.warn(error_at(directive.location, std::string(directive.name) +
                                                     " without its AttributeBegin is ignored, as pbrt ignores it"));
        return success();
    }
    if (!matches) {
        const std::string opener = block == Block::object ? "ObjectBegin" : "AttributeBegin";
        std::string hint;
        if (!stack_.empty() && stack_.back().block != Block::import)
            hint = "the innermost open block is the " +
                   std::string(stack_.back().block == Block::object ? "ObjectBegin" : "AttributeBegin") + " at line " +
                   std::to_string(stack_.back().opened.line);
        return error_at(directive.location, std::string(directive.name) + " without its " + opener, hint);
    }
    if (block == Block::object) active_object_ = {};
    state_ = std::move(stack_.back().state);
    stack_.pop_back();
    return success();
}

Status SceneReader::begin_import(const Directive& directive) {
    if (Status status = require_block(directive); !status) return status;
    stack_.push_back({Block::import, state_, directive.location, coordinate_systems_});
    return success();
}

Status SceneReader::end_import() {
    if (stack_.back().block != Block::import)
        return error_at(stack_.back().opened, "block is never closed; expected its end before the imported file's end");
    state_ = std::move(stack_.back().state);
    coordinate_systems_ = std::move(stack_.back().coordinate_systems);
    stack_.pop_back();
    return success();
}

Status SceneReader::world_begin(const Directive&) {
    in_world_ = true;
    state_.ctm = {Transform(), Transform()};
    state_.active = {true, true};
    coordinate_systems_["world"] = state_.ctm;
    return success();
}

Status SceneReader::color_space(const Directive& directive) {
    std::string name = directive.strings[0];
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::vector<std::string> known;
    for (const auto& row : space_names) {
        if (name == row.name) {
            state_.color_space = row.space;
            return success();
        }
        known.emplace_back(row.name);
    }
    scene_.warn(error_at(directive.string_locations[0],
                         "unknown colour space '" + directive.strings[0] +
                             "'; expected srgb, dci-p3, rec2020 or "
                             "aces2065-1. The previous space stays in use, as in pbrt-v4",
                         near_miss(name, known)));
    return success();
}

/// The empty name is pbrt's vacuum.
Status SceneReader::medium_interface(const Directive& directive) {
    const auto side = [&](std::size_t i) {
        if (directive.strings[i].empty()) return MediumHandle{};
        return scene_.medium_named({directive.strings[i], directive.string_locations[i]});
    };
    state_.inside_medium = side(0);
    state_.outside_medium = side(1);
    return success();
}

Status SceneReader::option(const Directive& directive) {
    static const std::vector<std::string> known{"disablepixeljitter",
                                                "disabletexturefiltering",
                                                "disablewavelengthjitter",
                                                "displacementedgescale",
                                                "forcediffuse",
                                                "msereferenceimage",
                                                "msereferenceout",
                                                "pixelstats",
                                                "rendercoordsys",
                                                "seed",
                                                "wavefront"};
    Parameter parameter = directive.parameters.parameters.front();
    std::erase_if(parameter.name, [](char c) { return c == '_' || c == '-'; });  // as pbrt-v4 does
    parameter.name = lower_case(parameter.name);
    if (std::find(known.begin(), known.end(), parameter.name) == known.end()) {
        return error_at(parameter.location, "unknown option '" + parameter.name + "'",
                        near_miss(parameter.name, known));
    }
    if (parameter.name == "disabletexturefiltering" && parameter.booleans.size() == 1) {
        if (parameter.booleans.front() != 0) scene_.disable_texture_filtering();
        return success();
    }
    if (parameter.name == "displacementedgescale" && parameter.numbers.size() == 1)
        return scene_.scale_displacement_edges(parameter.numbers.front(), parameter.location);
    scene_.warn(
        error_at(parameter.location, "option '" + parameter.name + "' has no effect here" +
                                         (parameter.name == "forcediffuse" ? ": materials stay as they are" : "")));
    return success();
}

Status SceneReader::attribute(Directive& directive) {
    static const std::vector<std::string> targets{"shape", "light", "material", "medium", "texture"};
    const std::string& target = directive.strings[0];
    if (std::find(targets.begin(), targets.end(), target) == targets.end())
        return error_at(
            directive.string_locations[0],
            "unknown target '" + target + "' of Attribute; expected shape, light, material, medium or texture");
    auto changed = std::make_shared<std::map<std::string, std::vector<DefaultParameter>>>(*state_.defaults);
    std::vector<DefaultParameter>& defaults = (*changed)[target];
    for (Parameter& parameter : directive.parameters.parameters) {
        std::erase_if(defaults, [&](const DefaultParameter& d) { return d.parameter.name == parameter.name; });
        defaults.push_back({std::move(parameter), state_.color_space});
    }
    // All of them are checked for every entity of their kind.
    if (defaults.size() > budget(Budget::parameters))
        return over_budget(Budget::parameters, "Attribute has set too many parameters of '" + target + "'",
                           directive.location.file, directive.location.line, directive.location.column);
    state_.defaults = std::move(changed);
    return success();
}

/// Embree finds intersections, and no image depends on the accelerator.
Status SceneReader::accelerator(Directive& directive) {
    ParameterSet& set = directive.parameters;
    const std::string& type = directive.strings[0];
    if (type != "bvh" && type != "kdtree")
        scene_.warn(error_at(directive.location, "accelerator '" + type +
                                                     "' is unknown; expected bvh or kdtree. Embree finds "
                                                     "intersections, whatever the accelerator"));
    std::vector<Error> warnings;
    Status checked =
        accelerators_.check(EntityKind::accelerator, directive.strings[0], set, set.parameters.size(), warnings);
    for (Error& warning : warnings) scene_.warn(std::move(warning));
    return checked;
}

Status SceneReader::settings(Directive& directive) {
    const std::string& type = directive.strings[0];
    switch (directive.id) {
        case DirectiveId::film:
            scene_.set_color_space(state_.color_space);
            return scene_.set_film(type, std::move(directive.parameters), directive.location);
        case DirectiveId::integrator:
            return scene_.set_integrator(type, std::move(directive.parameters), directive.location);
        case DirectiveId::pixel_filter:
            return scene_.set_filter(type, std::move(directive.parameters), directive.location);
        default:
            return scene_.set_sampler(type, std::move(directive.parameters), directive.location);
    }
}

Status SceneReader::camera(Directive& directive) {
    const auto& [first, last] = state_.ctm;
    coordinate_systems_["camera"] = {first.inverse(), last.inverse()};
    if (moves())
        return scene_.set_moving_camera(directive.strings[0], std::move(directive.parameters), first, last,
                                        state_.outside_medium, directive.location);
    return scene_.set_camera(directive.strings[0], std::move(directive.parameters), first, state_.outside_medium,
                             directive.location);
}

void convert_colors(ParameterSet& set, ColorSpace to, ColorSpace from, bool light) {
    if (to == from) return;
    const Matrix3 matrix = rgb_from_rgb(to, from, !light);
    for (Parameter& parameter : set.parameters) {
        const std::string_view name = parameter.name;
        const std::string_view last = name.substr(name.rfind('.') + 1);
        if (parameter.type != ParameterType::rgb || last == "eta" || last == "k" || last == "sigma_a" ||
            last == "sigma_s")
            continue;
        // Colours outside the target space: a reflectance is clamped to [0, 1], and a light stays positive.
        const double top = *std::max_element(parameter.numbers.begin(), parameter.numbers.end());
        for (std::size_t i = 0; i + 3 <= parameter.numbers.size(); i += 3) {
            const Triple rgb =
                multiply(matrix, Triple{parameter.numbers[i], parameter.numbers[i + 1], parameter.numbers[i + 2]});
            for (std::size_t c = 0; c < 3; ++c)
                parameter.numbers[i + c] = !light && top <= 1 ? std::clamp(rgb[c], 0.0, 1.0) : std::max(rgb[c], 0.0);
        }
    }
}

}  // namespace raylex::transport
