// The current transformation, composed on the right: the last directive acts first, as in pbrt.
#include "transport/import/pbrt/scene_reader.h"

namespace raylex::transport {

namespace {

/// Scene files write matrices column by column.
Transform from_columns(const std::array<double, 16>& numbers) {
    Matrix4 m{};
    for (std::size_t i = 0; i < 16; ++i) m[i % 4][i / 4] = numbers[i];
    return Transform(m);
}

}  // namespace

/// Applies a transformation. Singular ones are refused only when something is placed by them: some files hide objects
/// by flattening or shrinking them.
Status SceneReader::transform(const Directive& directive) {
    const std::array<double, 16>& n = directive.numbers;
    switch (directive.id) {
        case DirectiveId::translate:
            return concatenate(Transform::translate(n[0], n[1], n[2]));
        case DirectiveId::scale:
            return concatenate(Transform::scale(n[0], n[1], n[2]));
        case DirectiveId::rotate: {
            const Transform rotation = Transform::rotate(n[0], n[1], n[2], n[3]);
            if (!rotation.invertible())
                return error_at(directive.location,
                                "Rotate about a null axis; expected degrees and an axis of positive length");
            return concatenate(rotation);
        }
        case DirectiveId::look_at: {
            const Transform view = Transform::look_at({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]});
            if (!view.invertible())
                return error_at(directive.location,
                                "LookAt: the view direction is null or parallel to the up vector; expected eye, look, "
                                "up that span a view");
            return concatenate(view);
        }
        case DirectiveId::concat_transform:
            return concatenate(from_columns(n));
        case DirectiveId::coordinate_system:
            coordinate_systems_[directive.strings[0]] = state_.ctm;
            return success();
        case DirectiveId::coord_sys_transform: {
            const auto found = coordinate_systems_.find(directive.strings[0]);
            if (found != coordinate_systems_.end()) {
                state_.ctm = found->second;
                return success();
            }
            std::vector<std::string> known;
            for (const auto& [name, transforms] : coordinate_systems_) known.push_back(name);
            scene_.warn(error_at(directive.string_locations[0],
                                 "no coordinate system is called '" + directive.strings[0] +
                                     "'; the directive is ignored, as pbrt ignores it",
                                 near_miss(directive.strings[0], known)));
            return success();
        }
        default:
            break;
    }
    // Identity and Transform replace the current transformation.
    const Transform replacement = directive.id == DirectiveId::transform ? from_columns(n) : Transform();
    for (std::size_t i = 0; i < 2; ++i)
        if (state_.active[i]) state_.ctm[i] = replacement;
    return success();
}

Status SceneReader::active_transform(const Directive& directive) {
    const std::string& which = directive.strings[0];
    if (which != "StartTime" && which != "EndTime" && which != "All")
        return error_at(directive.string_locations[0],
                        "found '" + which + "'; expected StartTime, EndTime or All after ActiveTransform");
    state_.active = {which != "EndTime", which != "StartTime"};
    return success();
}

Status SceneReader::concatenate(const Transform& transform) {
    for (std::size_t i = 0; i < 2; ++i)
        if (state_.active[i]) state_.ctm[i] = state_.ctm[i] * transform;
    return success();
}

/// The transformation at the start, for entities that do not move in pbrt either.
const Transform& SceneReader::first_transform(const char* what, const SourceLocation& where) {
    if (moves())
        scene_.warn(error_at(
            where, std::string(what) + " under a moving transformation stand still, as in pbrt: where it starts"));
    return state_.ctm[0];
}

}  // namespace raylex::transport
