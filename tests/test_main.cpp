// Compiled once: the main of Catch2 2 is by far the slowest part of a test build. Catch2 3 has its own.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
