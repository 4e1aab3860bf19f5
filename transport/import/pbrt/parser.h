// Parses tokens into directives: the grammar of pbrt-v4 scene files, without semantics.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "transport/files/tokenizer.h"

namespace raylex::transport {

/// Every directive of pbrt-v4, in the order of the table in parser.cpp.
enum class DirectiveId : std::uint8_t {
    accelerator,
    active_transform,
    area_light_source,
    attribute,
    attribute_begin,
    attribute_end,
    camera,
    color_space,
    concat_transform,
    coordinate_system,
    coord_sys_transform,
    film,
    identity,
    import,
    include,
    integrator,
    light_source,
    look_at,
    make_named_material,
    make_named_medium,
    material,
    medium_interface,
    named_material,
    object_begin,
    object_end,
    object_instance,
    option,
    pixel_filter,
    reverse_orientation,
    rotate,
    sampler,
    scale,
    shape,
    texture,
    transform,
    transform_begin,
    transform_end,
    transform_times,
    translate,
    world_begin
};

/// A directive with its position and arguments: names and types in `strings`, matrices and vectors in `numbers`.
struct Directive {
    DirectiveId id = DirectiveId::identity;
    std::string_view name;    ///< in pbrt's spelling
    SourceLocation location;  ///< position of the directive's word
    std::vector<std::string> strings;
    std::vector<SourceLocation> string_locations;
    std::array<double, 16> numbers{};
    ParameterSet parameters;
    std::vector<Error> warnings;  ///< parameters given twice (the last value is used)
};

/// Returns the next directive, or nothing at the end of the text. Errors contain line, column, excerpt and what was
/// expected.
Result<std::optional<Directive>> parse_directive(Tokenizer& tokenizer);

/// Whether parameters may follow those of `directive`: an included file may continue the parameters of its Include's
/// directive.
bool takes_parameters(const Directive& directive);
/// Appends the parameters at the position of `tokenizer`, if any.
Status parse_more_parameters(Tokenizer& tokenizer, Directive& directive);

}  // namespace raylex::transport
