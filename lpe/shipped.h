// The partition of the beauty that ships with raylex. tests/lpe proves it over W.
#pragma once

#include <span>
#include <string_view>

#include "lpe/event.h"

namespace raylex::lpe {

struct NamedExpression {
    std::string_view name;
    std::string_view expression;
};

/// emissive, background, directDiffuse, indirectDiffuse, subsurface, directSpecular, indirectSpecular, transmissive,
/// volume: a partition of W in the given dialect.
[[nodiscard]] std::span<const NamedExpression> shipped_partition(Dialect dialect = Dialect::renderman);

/// An expression that accepts exactly W, the beauty.
[[nodiscard]] std::string_view beauty_expression(Dialect dialect = Dialect::renderman);

}  // namespace raylex::lpe
