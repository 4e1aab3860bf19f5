#include <catch2/catch.hpp>

#include "lpe/vectors.h"
#include "tests/support/paths.h"

using namespace raylex::lpe;

TEST_CASE("the osl dialect agrees with Open Shading Language on every conformance vector", "[vectors]") {
    const auto report = run_vectors(raylex::test::source_dir() + "/tests/lpe/data/lpe_vectors_osl.tsv", Dialect::osl);
    REQUIRE(report);
    for (const VectorRow& row : report->disagree) {
        UNSCOPED_INFO(row.line << ": " << row.expression << " on " << row.events << ": expected " << row.expected
                               << ", found " << row.found << " " << row.message);
    }
    CHECK(report->disagree.empty());
    CHECK(report->agree == 1616);
}

TEST_CASE("a failed vector is reported with its line and its result", "[vectors]") {
    const auto report = run_vectors_text(
        "# comment\nCDL\tC,- R,D L,-\t0\nC[\tC,-\t1\nCDL\tC,- R,D L,-\t1\nC()\t\tNOCRASH\n", "mine", Dialect::osl);
    REQUIRE(report);
    CHECK(report->agree == 2);
    REQUIRE(report->disagree.size() == 2);
    CHECK(report->disagree[0].line == 2);
    CHECK(report->disagree[0].found == "1");
    CHECK(report->disagree[1].found == "ERR");
    CHECK_FALSE(report->disagree[1].message.empty());
}

TEST_CASE("broken vector files are refused with file, line and column", "[vectors][law7]") {
    const auto missing = run_vectors("/nonexistent/file.tsv", Dialect::osl);
    REQUIRE_FALSE(missing);
    CHECK(missing.error().file == "/nonexistent/file.tsv");
    const auto short_row = run_vectors_text("CDL\tC,-\n", "mine", Dialect::osl);
    REQUIRE_FALSE(short_row);
    CHECK(short_row.error().line == 1);
    const auto bad_event = run_vectors_text("\nCDL\tC,- Q,D\t1\n", "mine", Dialect::osl);
    REQUIRE_FALSE(bad_event);
    CHECK(bad_event.error().line == 2);
    CHECK(bad_event.error().column == 9);
    const auto bad_result = run_vectors_text("CDL\tC,-\tmaybe\n", "mine", Dialect::osl);
    REQUIRE_FALSE(bad_result);
    CHECK(bad_result.error().column == 9);
}
