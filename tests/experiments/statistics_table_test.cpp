// The statistics of a render as a table of its page.
#include "experiments/report/statistics_table.h"

#include <catch2/catch.hpp>

#include "support.h"

namespace experiments = raylex::experiments;

TEST_CASE("the table of statistics counts what was traced and what was left out", "[report]") {
    const std::string table = experiments::statistics_table(R"({"phases": {}, "rays": {"camera": 1000, "pilot": 250},
        "pruned": {"light_paths": 40, "joins": 0}})");
    CHECK(contains(table, "Camera rays"));
    CHECK(contains(table, "Rays traced before the render, to tune sampling</td><td class=\"number\">250<"));
    CHECK(contains(table, "Light paths not started"));
    CHECK_FALSE(contains(table, "Connections"));  // its count is 0
    CHECK_FALSE(contains(experiments::statistics_table(R"({"phases": {}, "rays": {"camera": 1000, "pilot": 0}})"),
                         "Rays traced before"));
    const std::string guided = experiments::statistics_table(
        R"({"phases": {}, "guide": {"forecast_gain": 2.5, "guided_share": 0.5, "paid": {"image_share": 0.75}}})");
    CHECK(matches(guided,
                  "[^]*forecast gain</td><td class=\"number\">2.5<[^]*regions</td><td class=\"number\">50 %<[^]*"
                  "share of the image</td><td class=\"number\">75 %<[^]*"));
    CHECK_FALSE(contains(table, "Path guiding"));
    CHECK(experiments::statistics_table("no JSON").empty());
    CHECK(experiments::statistics_table("{}").empty());
}
