// Random light path expressions: the same on every machine.
#pragma once

#include <cstdint>
#include <string>

namespace raylex::experiments {

/// A light path expression between camera and light, `C ... [LO]`.
std::string random_expression(std::uint64_t seed);

}  // namespace raylex::experiments
