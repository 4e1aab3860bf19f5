// The table of a render's statistics on its page.
#include "experiments/report/statistics_table.h"

#include <catch2/catch.hpp>

#include "support.h"

namespace experiments = raylex::experiments;

TEST_CASE("the table of a render's statistics lists traced and omitted rays", "[report]") {
    const std::string table = experiments::statistics_table(R"({"phases": {}, "rays": {"camera": 1000, "pilot": 250},
        "pruned": {"light_paths": 40, "joins": 0}})");
    CHECK(contains(table, "Camera rays"));
    CHECK(contains(table, "Rays traced before, to choose how to sample</td><td class=\"number\">250<"));
    CHECK(contains(table, "Light paths not begun or ended"));
    CHECK_FALSE(contains(table, "Joins"));  // none were omitted
    CHECK_FALSE(contains(experiments::statistics_table(R"({"phases": {}, "rays": {"camera": 1000, "pilot": 0}})"),
                         "Rays traced before"));
    CHECK(experiments::statistics_table("no JSON").empty());
    CHECK(experiments::statistics_table("{}").empty());
}
