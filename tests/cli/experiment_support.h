// A small study and the steps that its tests share.
#pragma once

#include <catch2/catch.hpp>

#include <string>
#include <utility>

#include "experiments/study/results.h"
#include "support.h"

namespace raylex::test {

/// Two methods, two budgets and a reference, in the room of small_scene().
inline const std::string experiment_config = R"(replicates = 2
threads = 2
[[scene]]
name = "room"
file = "room.pbrt"
[[method]]
name = "deep"
[[method]]
name = "shallow"
max_depth = 2
[budget]
samples = [4, 24]
[reference]
method = "deep"
spp = 64
[[channel]]
name = "direct"
lpe = "CDL"
)";

inline void prepare(const Folder& folder, const std::string& text = experiment_config) {
    folder.write("room.pbrt", small_scene());
    folder.write("c.toml", text);
}

inline Outcome succeed(const Folder& folder, const std::string& arguments, int code = 0) {
    Outcome outcome = run_raylex(folder, arguments);
    INFO(arguments << "\n" << outcome.out << outcome.err);
    REQUIRE(outcome.code == code);
    return outcome;
}

inline experiments::Experiment results_of(const Folder& folder, const std::string& name) {
    auto read = experiments::read_experiment(folder.path(name));
    INFO((read ? std::string() : read.error().to_string()));
    REQUIRE(read);
    return *std::move(read);
}

}  // namespace raylex::test
