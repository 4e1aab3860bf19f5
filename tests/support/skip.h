// Marks a test that cannot run here. tests/run.sh counts these lines and prints the reasons.
#pragma once

#include <catch2/catch.hpp>
#include <iostream>
#include <string>

/// Leaves the test case and records it as skipped, with its reason.
#define RAYLEX_SKIP(reason)                                                                                         \
    do {                                                                                                            \
        std::cout << "SKIPPED " << Catch::getResultCapture().getCurrentTestName() << ": " << (reason) << std::endl; \
        SUCCEED("skipped");                                                                                         \
        return;                                                                                                     \
    } while (false)
