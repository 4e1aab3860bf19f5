// Which values a parameter may have, so that every scene can be written as a file that can be read.
#pragma once

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::transport {

/// Errors name the parameter: no values, values of another kind than its type's, numbers that are not finite or beyond
/// float, coordinates that are not whole points, integers beyond 32 bits.
Status check_values(const Parameter& parameter);

}  // namespace raylex::transport
