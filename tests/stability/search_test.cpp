// Random scenes: every invariant holds of them, and the search finds planted mistakes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "tests/stability/search/search.h"
#include "tests/support/folder.h"
#include "transport/lights/light_table.h"

using namespace raylex;
using namespace raylex::experiments;
namespace fs = std::filesystem;

namespace {

/// A point light of another making while it lives.
class PlantedLight {
  public:
    explicit PlantedLight(const std::function<void(transport::SceneLight&)>& mistake)
        : entry_(*transport::light_registry().find("point")) {
        auto planted = entry_;
        planted.factory = [mistake, right = entry_.factory](const transport::SceneLight& light,
                                                            transport::LightContext& context) {
            transport::SceneLight wrong = light;
            mistake(wrong);
            return right(wrong, context);
        };
        transport::light_registry().add(planted);
    }
    ~PlantedLight() { transport::light_registry().add(entry_); }
    PlantedLight(const PlantedLight&) = delete;
    PlantedLight& operator=(const PlantedLight&) = delete;

  private:
    Registry<transport::LightFactory>::Entry entry_;
};

SearchReport search(SearchOptions options, const test::Folder& folder) {
    options.folder = folder.path("found");
    auto report = search_scenes(options);
    if (!report) FAIL(report.error().to_string());
    return std::move(*report);
}

}  // namespace

TEST_CASE("scene search: every invariant holds of random scenes, or they are refused",
          "[invariants][law1][law6][law7]") {
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 250;
    options.means_every = 40;
    const SearchReport report = search(options, folder);
    for (const Finding& finding : report.findings)
        FAIL_CHECK("scene " << finding.scene << ", " << finding.invariant << ": " << finding.result.note << "\n"
                            << finding.text);
    // Most scenes must be worth the trouble, and every invariant must have been asked.
    CHECK(report.scenes == options.scenes);
    CHECK(report.refused < report.scenes / 3);
    for (const InvariantInfo& info : invariants()) {
        CAPTURE(std::string(info.name));
        if (info.name != "energy" && info.name != "integrator")
            CHECK(report.checked.count(std::string(info.name)) == 1);
    }
}

TEST_CASE("scene search: a planted mistake is found and shrunk", "[invariants]") {
    // Its light does not follow its factor: eight times the light is not eight times the image.
    const PlantedLight planted([](transport::SceneLight& light) {
        std::erase_if(light.parameters.parameters, [](const Parameter& p) { return p.name == "scale"; });
    });
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 200;
    options.most_findings = 1;
    options.check.only = {"unit-of-light"};
    const SearchReport report = search(options, folder);
    REQUIRE(report.findings.size() == 1);
    const Finding& finding = report.findings[0];
    CHECK(finding.invariant == "unit-of-light");
    INFO(finding.text);
    CHECK(finding.text.find("LightSource \"point\"") != std::string::npos);
    CHECK(finding.lines <= 8);  // a camera, a light, a shape and what places them
    CHECK(finding.lines < finding.lines_before / 2);
    CHECK(fs::exists(finding.file));
    CHECK(command_of(finding).find("--only unit-of-light") != std::string::npos);
}

TEST_CASE("scene search: a process that dies is a finding", "[invariants]") {
    const PlantedLight planted([](transport::SceneLight&) { std::raise(SIGKILL); });
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 100;
    options.most_findings = 1;
    options.check.only = {"finite"};
    const SearchReport report = search(options, folder);
    REQUIRE(report.findings.size() == 1);
    CHECK(report.findings[0].invariant == "death");
    CHECK(report.findings[0].result.note.find("SIGKILL") != std::string::npos);
    INFO(report.findings[0].text);
    CHECK(report.findings[0].lines <= 3);
}

// RAYLEX_SEARCH_SECONDS=3600 build/release/test_stability "[search]" searches for an hour from scene RAYLEX_SEARCH_SEED
// on; the folder raylex-search keeps what it finds.
TEST_CASE("scene search: every invariant holds for as long as the environment asks", "[search][.]") {
    const char* seconds = std::getenv("RAYLEX_SEARCH_SECONDS");
    const char* seed = std::getenv("RAYLEX_SEARCH_SEED");
    SearchOptions options;
    options.seconds = seconds != nullptr ? std::strtod(seconds, nullptr) : 60;
    options.seed = seed != nullptr ? std::strtoull(seed, nullptr, 10) : 0;
    const auto report = search_scenes(options);
    REQUIRE(report.ok());
    for (const Finding& finding : report->findings) FAIL_CHECK(finding.file << ": " << finding.result.note);
    WARN(report->scenes << " scenes, " << report->refused << " refused, " << report->tame << " of ordinary size");
}
