// Catch2 3 under the header name and with the global names of Catch2 2. The folder is on the include path only if
// CMake found Catch2 3.
#pragma once

#include <catch2/catch_approx.hpp>
#include <catch2/catch_message.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/catch_tostring.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/generators/catch_generators_adapters.hpp>
#include <catch2/interfaces/catch_interfaces_capture.hpp>

using Catch::Approx;
