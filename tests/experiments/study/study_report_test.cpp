// The report of a study with known results: its tables, files, plots and page.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "experiments/job/text/json.h"
#include "experiments/report/html.h"
#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/assets.h"
#include "experiments/study/report/page/pictures.h"
#include "experiments/study/report/paper/paper.h"
#include "experiments/study/report/study_report.h"
#include "support/skip.h"
#include "tests/experiments/browser.h"
#include "tests/experiments/study_support.h"

using namespace raylex::test;
using namespace raylex::experiments;
using raylex::experiments::Json;
using raylex::experiments::parse_json;

namespace {

std::vector<Json> lines_of(const std::string& text, const std::string& kind) {
    std::vector<Json> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        Json json = parse_json(line);
        if (json.at("kind") == kind) lines.push_back(std::move(json));
    }
    return lines;
}

bool has_d3() {
    return bool(read_d3());
}

/// $RAYLEX_KEEP_REPORT names a file for the page, for inspection.
void keep_report(const Folder& folder, const std::string& name) {
    const char* to = std::getenv("RAYLEX_KEEP_REPORT");
    if (to != nullptr)
        run_shell(folder, "mkdir -p '" + std::string(to) + "/" + name +
                              "' && cp -r study/report.html study/plots study/results.* '" + to + "/" + name + "'");
}

}  // namespace

TEST_CASE("a study's report has the known results", "[study][report][gate]") {
    if (!has_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    const Experiment experiment = write_synthetic_study(folder, {});
    std::filesystem::remove(experiment.runs[2].directory + "/bounce2.mean.npy");  // clamped, smallest budget
    REQUIRE(write_study_report(experiment) == 0);
    keep_report(folder, "small");
    const std::string jsonl = folder.read("study/results.jsonl");

    // Only the method with the planted error is reported, in its channel and not in the correct one.
    int skewed = 0, differing = 0;
    const std::vector<Json> bias = lines_of(jsonl, "bias");
    REQUIRE(bias.size() == 3 * 3);  // variants x channels
    for (const Json& line : bias) {
        CAPTURE(line.dump());
        REQUIRE(line["tested"] == true);
        const bool wrong =
            line["variant"] == "clamped" || (line["variant"] == "skewed" && line["channel"] != "bounce1");
        CHECK(line["differs"] == wrong);
        differing += wrong ? 1 : 0;
        if (line["variant"] == "skewed" && line["channel"] == "bounce2") {
            ++skewed;
            CHECK(line["mean_difference"].get<double>() == Approx(0.05).margin(0.005));
        }
    }
    CHECK(skewed == 1);
    CHECK(differing == 3 + 2);
    int named = 0;
    for (const Json& line : lines_of(jsonl, "first_words"))
        if (line["variant"] == "skewed") {
            ++named;
            CHECK(line["channel"] == "bounce2");
            // Camera, two scattering events, light: four events.
            CHECK(raylex::test::matches(line["path"].get<std::string>(), "C\\S* \\S+ \\S+ [LO]\\S*"));
        }
    CHECK(named == 1);

    // One sample's deviation is 0.4 of its pixel, so relmse-mean is 0.16 / n times the effect of the floor on dark
    // pixels.
    const auto reference = read_mean(experiment.scenes[0].reference, "bounce1");
    REQUIRE(reference);
    double mean = 0, kept = 0;
    const auto count = static_cast<double>(reference->values.size());
    for (const double value : reference->values) mean += value / count;
    for (const double value : reference->values) kept += value * value / (value * value + 0.01 * mean * mean) / count;
    int points = 0;
    for (const Json& line : lines_of(jsonl, "budget"))
        if (line["variant"] == "path max_depth=4" && line["channel"] == "bounce1" && line["budget"] == 128) {
            ++points;
            CHECK(line["relative_error"]["value"].get<double>() == Approx(0.4 * std::sqrt(kept / 128)).epsilon(0.01));
            CHECK(line["relative_error"]["low"] < line["relative_error"]["value"]);
            CHECK_FALSE(line["relative_error"].contains("note"));
        }
    CHECK(points == 1);
    int slopes = 0, shallow = 0, clamped = 0, against_seconds = 0;
    for (const Json& line : lines_of(jsonl, "slope")) {
        CAPTURE(line.dump());
        slopes += line["variant"] == "path max_depth=4" ? 1 : 0;
        shallow += line["variant"] == "skewed" && line["channel"] == "bounce2" ? 1 : 0;
        clamped += line["variant"] == "clamped" ? 1 : 0;
        if (line["variant"] == "path max_depth=4" && line["channel"] == "bounce1") {
            ++against_seconds;
            CHECK(line["against_seconds"]["slope"].get<double>() ==
                  Approx(-1).margin(0.05));  // without the preparation time
        }
        if (line["variant"] == "path max_depth=4")
            CHECK(line["against_samples"]["slope"].get<double>() == Approx(-1).margin(0.05));
        if (line["variant"] == "skewed" && line["channel"] == "bounce2") {
            CHECK(line["too_shallow"] == false);  // the bias is reported, and only once
            CHECK(line["verdict"] == "shallower than -1, as expected from the bias found here");
        }
        if (line["variant"] == "clamped") CHECK(line["too_shallow"] == false);  // it is declared biased
    }
    CHECK(slopes == 3);  // channels
    CHECK(shallow == 1);
    CHECK(clamped == 3);
    CHECK(against_seconds == 1);
    int extrapolated = 0;
    for (const Json& line : lines_of(jsonl, "time_to_error"))
        if (line["variant"] == "path max_depth=4" && line["channel"] == "bounce1" && line["relative_error"] == 0.01) {
            ++extrapolated;
            // 0.4^2 / 0.01^2 = 1600 samples of 0.01 s, fewer because of the floor, and 0.06 s of setup.
            CHECK(line["seconds"]["value"].get<double>() == Approx(16 * kept + 0.06).epsilon(0.02));
            CHECK(line["extrapolated"] == true);
        }
    CHECK(extrapolated == 1);
    // Methods that differ in one setting, swept or not, are compared in every channel.
    const std::vector<Json> settings = lines_of(jsonl, "setting");
    REQUIRE(settings.size() == 2 * 3);
    int speed_ups = 0, costs = 0;
    for (const Json& line : settings) {
        CAPTURE(line.dump());
        // Methods are named, with the setting in which they differ.
        CHECK(line["setting"] == "method");
        CHECK(line["from"] == "path");
        const bool strategy = line["to"] == "skewed";
        CHECK(line["others"] == (strategy ? "integrator.strategy default to light, max_depth=4"
                                          : "sample_filter.type none to clamp (luminance=10), max_depth=4"));
        speed_ups += strategy && line["channel"] == "bounce1" ? 1 : 0;
        costs += strategy ? 0 : 1;
        // Errors are equal, time is 1.1 times as long, setup is 0.06 s; replicates differ in their noise.
        if (strategy && line["channel"] == "bounce1") {
            CHECK(line["speed_up"]["value"].get<double>() == Approx(1 / 1.1).epsilon(0.02));
            // For normal noise, a median varies 1.25 times as much as the mean.
            CHECK(line["speed_up_by_medians"].get<double>() == Approx(1 / 1.1).epsilon(1.25 * 0.02));
        }
        if (!strategy) CHECK(line["speed_up"]["high"] < 1);  // a bias of a tenth costs most of the efficiency
    }
    CHECK(speed_ups == 1);
    CHECK(costs == 3);
    REQUIRE(lines_of(jsonl, "omission").size() == 3);
    CHECK(lines_of(jsonl, "run").size() == 4 * 5 * 3 + 1);

    const std::string csv = folder.read("study/results.csv");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 4 * 5 * 3 * 3 - 1);
    // The header has names for any program; a file beside it describes them, each once and in order.
    const std::string header = csv.substr(0, csv.find("\r\n")), columns = folder.read("study/results.columns.csv");
    CHECK(raylex::test::matches(header, "[a-z][a-z0-9_]*(,[a-z][a-z0-9_]*)*"));
    CHECK(columns.find("relmse_mean,,\"mean((a-b)^2 / (b^2 + (0.1 m)^2)), m = mean(|b|)\"") != std::string::npos);
    std::string described;
    std::istringstream meanings(columns);
    for (std::string line; std::getline(meanings, line);)
        if (!line.starts_with("column,")) described += (described.empty() ? "" : ",") + line.substr(0, line.find(','));
    CHECK(described == header);
    for (const char* plot : {"ramp.beauty.svg", "ramp.beauty.samples.svg", "ramp.bounce1.svg", "ramp.bounce2.svg",
                             "ramp.beauty.pareto.svg", "ramp.bounce1.pareto.svg", "ramp.bounce2.spectrum.svg"}) {
        CAPTURE(plot);
        const std::string svg = folder.read("study/plots/" + std::string(plot));
        CHECK(svg.starts_with("<svg xmlns="));
        CHECK(svg.find("NaN") == std::string::npos);
        CHECK(svg.find("clamped") != std::string::npos);
    }

    const std::string tex = folder.read("study/tables/ramp.beauty.tex");
    CHECK(tex.find("\nskewed & 128 samples & ") != std::string::npos);
    CHECK(tex.find("path max\\_depth=4 & ") != std::string::npos);
    CHECK(tex.ends_with("\\bottomrule\n\\end{tabular}\n"));

    const std::string page = folder.read("study/report.html");
    CHECK(raylex::test::count_matches(page, "e\\+[0-9]+ %") == 0);
    CHECK(page.find("<td class=\"number\">5</td><td class=\"number\">128 samples</td>") != std::string::npos);  // bias
    CHECK(page.find("killed by the &lt;system&gt;") != std::string::npos);
    CHECK(page.find("ramp.path.999.r0") != std::string::npos);
    CHECK(page.find("# &lt;/script&gt; &amp; more") != std::string::npos);
    CHECK(page.find("mean((a-b)^2 / (b^2 + (0.1 m)^2))") != std::string::npos);
    CHECK(page.find("is first wrong at the path") != std::string::npos);
    for (const char* fetch : {"src=\"http", "href=\"http", "<link", "@import", "url(http"})
        CHECK(page.find(fetch) == std::string::npos);
}

TEST_CASE("error spectra distinguish noise from bias by frequency, and maps show where images vary",
          "[study][report][gate]") {
    if (!has_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    const Experiment experiment = write_synthetic_study(folder, {});
    REQUIRE(write_study_report(experiment) == 0);
    const auto reference = read_mean(experiment.scenes[0].reference, "bounce2");
    REQUIRE(reference);
    double mean = 0, squares = 0;
    const auto count = static_cast<double>(reference->values.size());
    for (const double value : reference->values) mean += value / count;
    for (const double value : reference->values) squares += value * value / count;
    // Noise of 0.4 / sqrt(128) of each pixel, 0.4 / 256 in the reference.
    const double noise = 0.16 * (1.0 / 128 + 1.0 / 65536) * squares / (mean * mean);
    int spectra = 0;
    for (const Json& line : lines_of(folder.read("study/results.jsonl"), "spectrum")) {
        CAPTURE(line.dump());
        CHECK(line["replicates"] == 5);
        const auto frequencies = line["cycles_per_pixel"].get<std::vector<double>>(),
                   power = line["power"].get<std::vector<double>>(), least = line["least"].get<std::vector<double>>(),
                   most = line["most"].get<std::vector<double>>();
        REQUIRE(frequencies.size() > 15);
        CHECK(frequencies.front() == 0);
        CHECK(std::is_sorted(frequencies.begin(), frequencies.end()));
        for (std::size_t i = 0; i < power.size(); ++i) CHECK((least[i] <= power[i] && power[i] <= most[i]));
        if (line["channel"] != "bounce2" || line["variant"] == "clamped") continue;
        ++spectra;
        // The study knows the exact variance of the reference; `squares` is of the noisy reference. Its relative
        // standard error is at most 2 x (0.4 / 256) / sqrt(count / 3), because a few bright pixels weigh more; four of
        // them.
        CHECK(line["reference_error"].get<double>() ==
              Approx(0.4 / 256 * std::sqrt(squares) / mean).epsilon(4 * 2 * 0.4 / 256 / std::sqrt(count / 3)));
        // Except at the corners, the last rings have 5 x 3 x hundreds of values each, whose squares vary as much as
        // their mean.
        for (std::size_t i = power.size() - 5; i + 1 < power.size(); ++i) CHECK(power[i] == Approx(noise).epsilon(0.1));
        // 5 % too bright: the frequency 0 has pixels x 0.05^2, far above the noise; three components of five replicates
        // of pure noise stay within a few times its mean.
        const bool skewed = line["variant"] == "skewed";
        if (skewed) CHECK(power[0] == Approx(64 * 48 * 0.05 * 0.05).epsilon(0.2));
        else CHECK(power[0] < 10 * noise);
    }
    CHECK(spectra == 2);
    for (const char* variant : {"path_max_depth_4", "skewed", "clamped"})
        CHECK(folder.read("study/spectra/ramp." + std::string(variant) + ".deviation.png").starts_with("\x89PNG"));
    const std::string page = folder.read("study/report.html");
    CHECK(page.find("data-plot=\"s0-bounce2--spectrum\"") != std::string::npos);
    CHECK(raylex::test::count_matches(page, "alt=\"standard deviation of ") == 3);
    const auto study = study_of(experiment, {});
    REQUIRE(study);
    for (const ErrorSpectrum& each : study->spectra) {
        CHECK(each.deviation.values.empty() == (each.curve->channel != "beauty"));
        if (each.deviation.values.empty()) continue;
        // On the disc, the noise is that of brighter light.
        const auto at = [&](double u, double v) {
            double sum = 0;
            for (int y = -2; y <= 2; ++y)
                for (int x = -2; x <= 2; ++x)
                    sum += each.deviation.values[static_cast<std::size_t>((v * 48 + y) * 1) * 64 +
                                                 static_cast<std::size_t>(u * 64 + x)];
            return sum / 25;
        };
        CHECK(at(0.6, 0.45) > 1.5 * at(0.15, 0.8));
    }
}

TEST_CASE("a study's page works in a browser", "[study][report][gate]") {
    if (!has_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    const Experiment experiment = write_synthetic_study(folder, {32, 24, 1, 3, 3, 3, 2, 0.4});
    REQUIRE(write_study_report(experiment) == 0);
    // The viewer decoded and drew, and read a pixel of every channel.
    const Outcome page = in_browser(folder, "study/report.html", "1400,12000", {"[data-painted]", "[data-read=yes]"});
    CAPTURE(page.err);
    CHECK(page.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(page.out.empty());
    CHECK(raylex::test::count_matches(page.out, "100\\.0 %") >= 2);  // the beauty's share of itself, in A and in B
    // The plot on the page equals the one in the file except for the colours of text and paper.
    const std::string file = folder.read("study/plots/ramp.beauty.svg");
    const std::string line = file.substr(file.find("<path d=\"M", file.find("class=\"series\"")), 60);
    CHECK(page.out.find(line) != std::string::npos);
}

TEST_CASE("pictures keep half precision, and are reduced when a page would be too large", "[study][report]") {
    const PixelArray image{2, 4, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 1, 1, 1, 1, 1, 1, 1e6, -1e6, 0, 0, 0, 0}};
    const PixelArray half = reduced(image, 2);
    CHECK(half.width == 2);
    CHECK(half.height == 1);
    CHECK(half.values[0] == (1 + 4 + 1 + 1) / 4.0);
    CHECK(half.values[3] == (7 + 10 + 1e6 + 0) / 4.0);
    CHECK(encode_picture(image).size() % 4 == 0);
    const std::string text = "any carnal pleasure";  // RFC 4648's alphabet with each padding
    const auto bytes = [&](std::size_t n) {
        return base64(std::span(reinterpret_cast<const unsigned char*>(text.data()), n));
    };
    CHECK(bytes(19) == "YW55IGNhcm5hbCBwbGVhc3VyZQ==");
    CHECK(bytes(18) == "YW55IGNhcm5hbCBwbGVhc3Vy");
    CHECK(bytes(17) == "YW55IGNhcm5hbCBwbGVhc3U=");
}

TEST_CASE("numbers are formatted as people write them", "[study][report]") {
    CHECK(plain_number(3210) == "3210");
    CHECK(plain_number(3214) == "3210");
    CHECK(plain_number(999.6) == "1000");
    CHECK(plain_number(0.5) == "0.5");
    CHECK(plain_number(0.000123456) == "0.000123");
    CHECK(plain_number(-12.34) == "-12.3");
    CHECK(plain_number(0) == "0");
    CHECK(plain_number(0.9999) == "1");
    CHECK(percent_text(32.1) == "3210 %");
    CHECK(spoken_budget(BudgetKind::samples, 1) == "1 sample");
    CHECK(spoken_budget(BudgetKind::samples, 2) == "2 samples");
    CHECK(spoken_budget(BudgetKind::seconds, 30) == "30 s");
    CHECK(spoken_budget(BudgetKind::error, 0.01) == "to 1 %");
    CHECK(latex_text("a_b & 5 % of {x}\\") == "a\\_b \\& 5 \\% of \\{x\\}\\textbackslash{}");
}

TEST_CASE("insets are the study's regions, else the places with the largest differences from the reference",
          "[study][report]") {
    if (!has_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    Experiment experiment = write_synthetic_study(folder, {40, 40, 1, 1, 2, 3, 2, 0.01});
    // An additional error in the picture of `skewed`, the first replicate of its last budget.
    for (const StudyRun& run : experiment.runs)
        if (run.method == "skewed" && !run.failed && run.replicate == 0) {
            auto image = read_mean(run.directory, "beauty");
            REQUIRE(image);
            for (std::size_t y = 24; y < 32; ++y)
                for (std::size_t x = 8; x < 16; ++x)
                    for (std::size_t c = 0; c < 3; ++c) image->values[(y * 40 + x) * 3 + c] *= 3;
            REQUIRE(write_npy(run.directory + "/beauty.mean.npy", *image));
        }
    auto study = study_of(experiment, {});
    REQUIRE(study);
    std::vector<InsetBox> boxes = inset_boxes(*study, 0);
    REQUIRE(boxes.size() == 2);
    CHECK(boxes[0].x == 8);
    CHECK(boxes[0].y == 24);
    CHECK(boxes[0].width == 8);
    experiment.regions = {{"corner", "", {1, 2, 11, 22}, ""}};
    boxes = inset_boxes(*study, 0);
    REQUIRE(boxes.size() == 1);
    CHECK(boxes[0].y == 2);
    CHECK(boxes[0].height == 20);
    REQUIRE(write_study_report(experiment) == 0);
    CHECK(folder.has("study/insets/ramp.reference.inset1.png"));
    CHECK(folder.has("study/insets/ramp.skewed.png"));
    const std::string figure = folder.read("study/insets/ramp.svg");
    CHECK(figure.find("error ") != std::string::npos);
    std::size_t pictures = 0;
    for (std::size_t at = 0; (at = figure.find("<image ", at)) != std::string::npos; ++at) ++pictures;
    CHECK(pictures == 1 + 3);  // the whole reference; an inset of each variant and of the reference
}

TEST_CASE("a report without d3 names the package", "[study][report]") {
    setenv("RAYLEX_D3", "/no/such/d3.js", 1);
    const auto d3 = read_d3();
    unsetenv("RAYLEX_D3");
    REQUIRE_FALSE(d3);
    CHECK(d3.error().file == "/no/such/d3.js");
    CHECK(d3.error().message.find("libjs-d3") != std::string::npos);
}

TEST_CASE("a report of 200 cells with images stays small and opens soon", "[.full][study]") {
    if (!has_d3()) RAYLEX_SKIP("needs the package libjs-d3");
    const Folder folder;
    // 3 scenes x 6 variants x 4 budgets x 3 replicates = 216 cells of 480 x 320 pixels and 6 channels.
    const Experiment experiment = write_synthetic_study(folder, {480, 320, 3, 4, 3, 6, 6, 0.4});
    REQUIRE(write_study_report(experiment) == 0);
    keep_report(folder, "large");
    const std::string page = folder.read("study/report.html");
    std::printf("%zu cells: report.html %.1f MB\n", experiment.runs.size(), static_cast<double>(page.size()) * 1e-6);
    CHECK(page.size() < 60'000'000);
}
