// Hard cases that no image shows: closures, lights, geometry and sums against references in double precision. The cases
// are the *.toml files of this folder, in the format of `raylex stability`; a probe measures each.
#include <catch2/catch.hpp>

#include <algorithm>
#include <set>

#include "experiments/stability/suite/case_file.h"
#include "experiments/stability/suite/suite_runner.h"
#include "tests/stability/probes/probes.h"
#include "tests/support/paths.h"

using namespace raylex;
using namespace raylex::experiments;
using namespace raylex::test;

namespace {

const std::string own_cases = source_dir() + "/tests/stability";

std::vector<CaseFamily> read(const std::vector<std::string>& files) {
    static const bool once = (register_probes(), true);
    (void)once;
    auto families = read_case_files(files);
    if (!families) FAIL(families.error().to_string());
    return std::move(*families);
}

void check_lines(const SuiteOptions& options) {
    const auto families = read({own_cases});
    const auto results = run_suite(families, options, nullptr, [](const std::vector<LineResult>& lines) {
        for (const LineResult& line : lines)
            if (line.result != LineState::holds)
                FAIL_CHECK(line.family << ", " << line.name << ", " << line.setting << ": expected " << line.expected
                                       << ", measured " << line.measured << ", tolerance " << line.tolerance << "; "
                                       << line.note);
    });
    REQUIRE(results.ok());
    CHECK(results->lines.size() > 100);
}

}  // namespace

TEST_CASE("the fast half of the probed cases holds", "[stability][release-only]") {
    SuiteOptions fast;
    fast.fast = true;
    check_lines(fast);
}

TEST_CASE("all probed cases hold", "[stability][.full]") {
    check_lines({});
}

TEST_CASE("every case gives its reason, and every row of the hard cases has one", "[stability]") {
    const auto families = read({source_dir() + "/experiments/stability", own_cases});
    std::set<int> covered;
    for (const CaseFamily& family : families) {
        CAPTURE(family.file);
        CHECK(!family.about.empty());
        if (!family.picture.empty())
            CHECK(std::any_of(family.cases.begin(), family.cases.end(),
                              [&](const StabilityCase& each) { return each.name == family.picture && each.scene; }));
        for (const StabilityCase& each : family.cases) {
            CAPTURE(each.name);
            CHECK(each.settings().ok());
            CHECK((each.reason.size() > 10 || !each.not_applicable.empty()));
            covered.insert(each.rows.begin(), each.rows.end());
        }
    }
    for (int row = 1; row <= 68; ++row) {
        CAPTURE(row);
        CHECK(covered.count(row) == 1);
    }
}
