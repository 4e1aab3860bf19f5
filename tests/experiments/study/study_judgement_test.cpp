// The conclusions of a study: bias verdicts with reasons, the best method, and the beginning of the page.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "experiments/job/text/json.h"
#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/assets.h"
#include "experiments/study/report/study_report.h"
#include "support/skip.h"
#include "tests/experiments/study_support.h"

using namespace raylex::test;
using namespace raylex::experiments;

namespace {

constexpr SyntheticStudy small{32, 24, 1, 4, 5, 3, 2, 0.4};

Study checked(const Experiment& experiment) {
    auto study = study_of(experiment, {});
    REQUIRE(study);
    return *std::move(study);
}

const BiasEntry& entry_of(const Study& study, std::string_view variant, std::string_view channel) {
    for (const BiasEntry& each : study.bias)
        if (each.variant == variant && each.channel == channel) return each;
    FAIL("no verdict on " << variant << ", " << channel);
    return study.bias.front();
}

std::string page_of(const Folder& folder, const Experiment& experiment) {
    REQUIRE(write_study_report(experiment) == 0);
    return folder.read("study/report.html");
}

/// Makes the reference by a method without variances, with light in one channel that its replicates lack.
void spoil_reference(const SceneInfo& scene, const std::string& channel, double factor) {
    for (const ChannelInfo& each : scene.channels)
        std::filesystem::remove(scene.reference + "/" + each.name + ".m2.npy");
    auto mean = read_mean(scene.reference, channel);
    REQUIRE(mean);
    for (double& value : mean->values) value *= factor;
    REQUIRE(write_npy(scene.reference + "/" + channel + ".mean.npy", *mean));
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("a verdict on bias has sign, size, interval and place", "[study][gate]") {
    const Folder folder;
    const Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 4, 5, 3, 3, 0.4});
    const Study study = checked(experiment);
    const BiasEntry &skewed = entry_of(study, "skewed", "bounce2"), &clamped = entry_of(study, "clamped", "beauty");
    for (const auto& [entry, truth] : {std::pair(&skewed, 0.05), std::pair(&clamped, -0.1)}) {
        const Interval& mean = entry->result.mean_difference;
        CHECK(entry->conclusion() == BiasConclusion::differs);
        CHECK(mean.low < truth);
        CHECK(mean.high > truth);
        CHECK(mean.low * mean.high > 0);  // the interval is at the level of the rejecting test
    }
    CHECK(matches(finding_of(study, skewed), "\\+(4\\.9|5|5\\.0)[0-9]* % \\[[0-9.]+, [0-9.]+\\] of the mean"));
    CHECK(matches(finding_of(study, clamped), "-(9\\.9|10|10\\.0)[0-9]* % \\[-[0-9.]+, -[0-9.]+\\] of the mean"));
    // A single block is described differently.
    BiasEntry block = skewed;
    block.result.worst_is_whole = false;
    block.result.worst = 5;  // of four across
    block.result.worst_difference = {0.009, 0.004, 0.014, {}, {}};
    block.result.mean_difference = {0.0006, -0.0001, 0.0013, {}, {}};
    CHECK(finding_of(study, block) == "+0.9 % [0.4, 1.4] in the block at (16, 16), +0.06 % [-0.01, 0.13] of the mean");
}

TEST_CASE("a method is not judged on channels with its declared omissions, and only on those",
          "[study][report][gate]") {
    if (!read_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, small);
    for (StudyRun& run : experiment.runs)
        if (run.method == "skewed") run.omits = {{"C[DSV][DSV].*", "renderman"}};
    const Study study = checked(experiment);
    CHECK(entry_of(study, "skewed", "bounce2").result.differs);
    CHECK(entry_of(study, "skewed", "bounce2").conclusion() == BiasConclusion::omits_paths);
    CHECK(entry_of(study, "skewed", "bounce1").conclusion() == BiasConclusion::none_found);
    const std::string page = page_of(folder, experiment);
    CHECK(has(page,
              "Not judged, because the method declares that it does not find such paths:</span> skewed on ramp "
              "(C[DSV][DSV].*)"));
    CHECK_FALSE(has(page, "No verdict on bias, because a few rare samples dominate"));
}

TEST_CASE("if a bias above a tenth would be missed, the verdict is open", "[study][report]") {
    if (!read_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    // One degree of freedom: critical values of hundreds of standard errors.
    const Experiment experiment = write_synthetic_study(folder, {32, 24, 1, 1, 2, 3, 1, 2});
    const Study study = checked(experiment);
    const BiasEntry& entry = entry_of(study, "path max_depth=4", "beauty");
    REQUIRE(entry.result.tested);
    CHECK(entry.result.detectable_whole > largest_hidden_bias);
    CHECK(entry.conclusion() == BiasConclusion::cannot_tell);
    CHECK(has(result_of(study, entry), " of the mean would be missed"));
    const std::string page = page_of(folder, experiment);
    CHECK(has(page, "Cannot tell about bias:</span> path max_depth=4 on ramp (beauty, bounce1, bounce2)"));
    CHECK_FALSE(has(page, "o bias found</"));
    CHECK(has(folder.read("study/results.jsonl"), "\"verdict\":\"cannot tell: a bias below "));
}

TEST_CASE("values that are not finite do not count as agreement", "[study]") {
    const double nan = std::nan("");
    const BiasSide broken{{{1, nan}, {1.1, nan}}, {}}, all{{{nan, nan}, {nan, nan}}, {}},
        reference{{{1, 1}}, {0.01, 0.01}};
    CHECK(std::isinf(test_bias(broken, reference).detectable_whole));
    CHECK_FALSE(test_bias(all, reference).tested);
}

TEST_CASE("the method that made the reference is judged by another one", "[study][gate]") {
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 2, 5, 3, 2, 0.4});
    experiment.scenes[0].reference_method = "skewed";  // the path agrees with the reference, so it can judge
    Study study = checked(experiment);
    CHECK(entry_of(study, "skewed", "bounce2").against == "path max_depth=4");
    CHECK(entry_of(study, "skewed", "bounce2").convicts());
    CHECK(entry_of(study, "path max_depth=4", "bounce2").against.empty());
    // Two methods that disagree: one is wrong, and a reference by the other does not show which.
    experiment.scenes[0].reference_method = "path max_depth=4";
    study = checked(experiment);
    CHECK(entry_of(study, "path max_depth=4", "bounce2").conclusion() == BiasConclusion::cannot_tell);
    CHECK(has(entry_of(study, "path max_depth=4", "bounce2").caveat, "no other method agrees with it"));
    CHECK(entry_of(study, "path max_depth=4", "bounce1").against == "skewed");
    // Without a second method it is judged by its own reference, and the table shows that.
    const Folder alone;
    experiment = write_synthetic_study(alone, {64, 48, 1, 2, 5, 3, 1, 0.4});
    experiment.scenes[0].reference_method = "path max_depth=4";
    study = checked(experiment);
    CHECK(entry_of(study, "path max_depth=4", "beauty").conclusion() == BiasConclusion::none_found);
    CHECK(has(entry_of(study, "path max_depth=4", "beauty").result.note, "a mistake in both is not found"));
}

TEST_CASE("with a reference of unknown error, a bias needs confirmation by another method's images", "[study][gate]") {
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 4, 5, 3, 2, 0.4});
    experiment.scenes[0].reference_method = "path max_depth=4";
    spoil_reference(experiment.scenes[0], "bounce1", 1.1);
    const Study study = checked(experiment);
    const BiasEntry &met = entry_of(study, "skewed", "bounce1"), &wrong = entry_of(study, "skewed", "bounce2");
    CHECK(met.result.differs);  // by the 10 % that only the reference has
    CHECK(met.conclusion() == BiasConclusion::cannot_tell);
    CHECK(has(result_of(study, met),
              "cannot tell: it differs from the reference, whose own error is unknown, and no "
              "other method's images confirm it: -9"));
    CHECK(wrong.convicts());  // the path's own images confirm it
    CHECK(entry_of(study, "path max_depth=4", "bounce1").conclusion() == BiasConclusion::cannot_tell);
    const std::vector<std::string> lines = result_lines(study);
    REQUIRE(lines.size() == 2);
    CHECK(has(lines[1], "whose own error is unknown"));
    // Unknown noise is not subtracted, and no plot claims so.
    for (const Plot& plot : plots_of(study)) CHECK_FALSE(has(plot.json, "noise subtracted"));
    const Folder known;
    CHECK(has(plots_of(checked(write_synthetic_study(known, small))).front().json, "noise subtracted"));
}

TEST_CASE("with a bias or missing paths, times to an error are not extrapolated", "[study][gate]") {
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 4, 5, 3, 3, 0.4});
    const auto least_time = [&](const char* variant, const char* channel) {
        return checked(experiment).curve("ramp", variant, channel)->times.back().seconds;
    };
    REQUIRE(std::isfinite(least_time("path max_depth=4", "bounce2").value));
    const Interval biased = least_time("clamped", "beauty");
    CHECK(std::isnan(biased.value));
    CHECK(matches(biased.note, "not followed beyond [0-9.]+ % after [0-9.]+ s, because it differs by -.*"));
    for (StudyRun& run : experiment.runs)
        if (run.method == "path") run.omits = {{"C[DSV][DSV].*", "renderman"}};
    const Interval without = least_time("path max_depth=4", "bounce2");
    CHECK(std::isnan(without.value));
    CHECK(has(without.note, "because it does not find C[DSV][DSV].*"));
    CHECK(std::isfinite(least_time("path max_depth=4", "bounce1").value));
}

TEST_CASE("the first wrong path belongs to the channel in the verdict", "[study][gate]") {
    const Folder folder;
    const Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 4, 5, 3, 3, 0.4});
    Study study = checked(experiment);
    REQUIRE_FALSE(study.words.empty());
    for (BiasEntry& entry : study.bias)
        if (entry.channel == "beauty") entry.result.differs = false;
    study.words = {
        {"ramp", "skewed", {{{"rest", "C,- L,-", "", 2, 0.001}, {"bounce2", "C,- R,D L,-", "", 3, 1e-5}}, {}}}};
    REQUIRE(first_counterexample(study, "ramp", "skewed") != nullptr);
    CHECK(first_counterexample(study, "ramp", "skewed")->channel == "bounce2");
    study.words[0].first.words.pop_back();
    CHECK(first_counterexample(study, "ramp", "skewed") == nullptr);
    CHECK_FALSE(has(result_lines(study)[1], "first wrong path"));
}

TEST_CASE("the page begins with all channels by all methods, and the best method", "[study][report][gate]") {
    if (!read_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {64, 48, 1, 6, 5, 3, 2, 0.4});
    for (StudyRun& run : experiment.runs)  // four times as slow
        if (run.method == "skewed") run.wall_seconds *= 4;
    const Study study = checked(experiment);
    REQUIRE(study.comparisons.size() == 3);
    const MethodComparison& bounce1 = study.comparisons[1];
    CHECK(bounce1.channel == "bounce1");
    // The path's largest budget: 512 samples at 0.01 s and 0.06 s of preparation.
    CHECK(bounce1.seconds == Approx(5.18));
    CHECK(bounce1.best == 0);
    // In that time the other method takes a quarter of its largest number of samples, at 0.011 s each after 0.06 s. The
    // error goes as 1 / samples, so the ratio is that of the samples.
    const double samples = (5.18 / 4 - 0.06) / 0.011;
    // straight lines in logarithms bend because of the setup
    CHECK(bounce1.ratio.value == Approx(512 / samples).epsilon(0.03));
    CHECK(bounce1.ratio.low > 1);
    CHECK(matches(best_sentence(study, bounce1),
                  "path max_depth=4 for bounce1: [0-9.]+ times less squared error in the same time than skewed "
                  "\\[[0-9.]+, [0-9.]+\\]"));
    const std::string page = page_of(folder, experiment);
    const std::size_t table = page.find("<div class=\"first\">"), results = page.find("Every split sums");
    REQUIRE(table != std::string::npos);
    CHECK(table < results);
    CHECK(page.find("<table") > table);
    CHECK(has(page, "1 % not reached"));  // skewed, in its wrong channel, stops at its bias
    CHECK(has(page.substr(table, results - table), "<b>"));
    CHECK_FALSE(has(page, "against seconds</th>"));
    CHECK(count_matches(page, "Slope over the last 4 octaves") == 3);  // one column, in the panel of each channel
    // The axis of samples shows the budgets of the study.
    const std::string plot = folder.read("study/plots/ramp.beauty.samples.svg");
    for (const char* budget : {">16</text>", ">32</text>", ">64</text>", ">128</text>", ">512</text>"})
        CHECK(has(plot, budget));
    CHECK_FALSE(has(plot, ">100</text>"));
    CHECK(has(plot, "falls with slope -"));
}

TEST_CASE("errors at a time between budgets, and outside of them", "[study]") {
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {32, 24, 1, 1, 5, 3, 2, 0.4});  // one budget each
    const MethodComparison one = checked(experiment).comparisons[1];
    CHECK_FALSE(one.standings[0].extrapolated);
    CHECK(one.standings[1].extrapolated);  // it took longer than the path's only budget
    CHECK(one.standings[1].squared.value > one.standings[0].squared.value);
}

TEST_CASE("a ratio or time with an uncertainty of more than a factor of 100 is not a result", "[study]") {
    const std::vector<double> wild{1, 1e-3}, same{1, 1.01}, seconds{1, 1};
    const Interval none = speed_up_interval({wild, seconds}, {same, seconds});
    CHECK(std::isnan(none.value));
    CHECK(none.note == wide_note);
    CHECK(speed_up_interval({same, seconds}, {same, seconds}).valid());
    const std::vector<BudgetGroup> two{{1, {1, 0.01}, seconds, {}, 0, false, false}};
    CHECK(time_to_error(two, 0.1).seconds.note == wide_note);
}

TEST_CASE("a reference that is too coarse for the errors is named at the top of the page", "[study][report][gate]") {
    if (!read_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    // 0.8 / sqrt(65536) = 0.31 %, above half of 0.5 %; `small` has half of that.
    const std::string coarse = page_of(folder, write_synthetic_study(folder, {32, 24, 1, 1, 2, 3, 1, 0.8}));
    const std::size_t at = coarse.find("Coarse references, whose own error exceeds 0.25 %");
    REQUIRE(at != std::string::npos);
    CHECK(at < coarse.find("<div class=\"first\">"));
    const Folder fine;
    CHECK_FALSE(has(page_of(fine, write_synthetic_study(fine, small)), "Coarse references"));
}
