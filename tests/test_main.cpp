// Compiled once: Catch2 2.x is header-only and its main is by far the slowest part of a test build.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
