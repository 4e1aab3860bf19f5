// Checks the values of parameters, so that every scene can be written as a file that can be read.
#pragma once

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::transport {

/// Checks one parameter. Errors name it: no values, values of another kind than its type, numbers that are not finite
/// or beyond float, coordinates that are not whole points, integers beyond 32 bits.
Status check_values(const Parameter& parameter);

}  // namespace raylex::transport
