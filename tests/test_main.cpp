// Compiled once: Catch2 2 is header-only and its main is by far the slowest part of a test build. Catch2 3 has a library.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
