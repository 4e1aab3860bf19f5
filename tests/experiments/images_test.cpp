// verify, compare and report on images with known results.
#include <catch2/catch.hpp>

#include <cmath>

#include "browser.h"
#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/output/writer/exr_writer.h"
#include "display/services/samples/sample_table.h"
#include "support/skip.h"

using namespace raylex::test;
namespace display = raylex::display;

namespace {

constexpr int size = 4;

display::ChannelDefinition colour(const std::string& name, const std::string& expression = {}) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = expression.empty() ? display::ChannelStyle::name : display::ChannelStyle::expression;
    channel.expression = expression;
    return channel;
}

/// Writes a 4x4 image with one sample per pixel: beauty = 1, 2, 3 in R, G, B, `a` a quarter and `b` three quarters of
/// it; pixel (2, 1) of `b` is wrong by `error`.
void write_image(const std::string& path, double error, const std::vector<display::PartitionDeclaration>& partitions,
                 double scale = 1) {
    std::vector<display::ChannelDefinition> channels{colour("beauty"), colour("a", "CDL"), colour("b", "C<RD>SL")};
    display::FrameBufferLayout layout;
    layout.width = size;
    layout.height = size;
    display::FrameBuffer buffer(layout, channels);
    display::SampleTable table(channels, 1);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            display::CameraRow row;
            row.pixel_x = x;
            row.pixel_y = y;
            table.begin({&row, 1});
            table.valid[0] = 1;
            for (int id = 0; id < 3; ++id) {
                table.touch(id);
                for (int c = 0; c < 3; ++c) {
                    const double whole = (c + 1) * scale, share = id == 0 ? 1 : id == 1 ? 0.25 : 0.75;
                    table.raw_values(id)[c] = whole * share + (id == 2 && x == 2 && y == 1 ? error : 0);
                }
            }
            buffer.accumulate(table);
        }
    display::ImageDescription description;
    description.partitions = partitions;
    raylex::Status written = display::write_exr(path, buffer, 0, description);
    REQUIRE(written);
}

const std::vector<display::PartitionDeclaration> halves{{"halves", "", {"a", "b"}}};

}  // namespace

TEST_CASE("verify accepts a split that sums, with numbers", "[law1]") {
    const Folder folder;
    write_image(folder.path("good.exr"), 0, halves);
    Outcome outcome = run_raylex(folder, "verify good.exr");
    CHECK(outcome.code == 0);
    CHECK(outcome.out.find("'halves'") != std::string::npos);
    CHECK(outcome.out.find("holds") != std::string::npos);
    CHECK(outcome.out.find("largest absolute error 0 at pixel") != std::string::npos);
    CHECK(outcome.out.find("2^-23") != std::string::npos);
    CHECK(folder.names() == std::vector<std::string>{"good.exr"});
}

TEST_CASE("verify rejects a doctored file, names the pixel and writes a heat map", "[law1]") {
    const Folder folder;
    write_image(folder.path("bad.exr"), 1e-3, halves);
    Outcome outcome = run_raylex(folder, "verify bad.exr");
    CHECK(outcome.code == 1);
    CHECK(outcome.out.find("DOES NOT HOLD") != std::string::npos);
    CHECK(outcome.out.find("(2, 1)") != std::string::npos);
    CHECK(folder.has("bad.halves.residual.png"));
    // With several files, one failure decides.
    write_image(folder.path("good.exr"), 0, halves);
    CHECK(run_raylex(folder, "verify good.exr bad.exr").code == 1);
    CHECK(run_raylex(folder, "verify good.exr good.exr").code == 0);
}

TEST_CASE("verify checks layers of any renderer by --of and --sum") {
    const Folder folder;
    write_image(folder.path("x.exr"), 0, {});
    Outcome nothing = run_raylex(folder, "verify x.exr");
    CHECK(nothing.code == 2);
    CHECK(nothing.err.find("--sum") != std::string::npos);
    CHECK(nothing.err.find("raylex verify x.exr --of beauty --sum a,b,...") != std::string::npos);
    // The suggested command is valid in a shell.
    write_image(folder.path("it's one.exr"), 0, {});
    CHECK(contains(run_raylex(folder, "verify \"it's one.exr\"").err, "raylex verify 'it'\\''s one.exr' --of beauty"));
    CHECK(run_raylex(folder, "verify x.exr --of beauty --sum a,b").code == 0);
    CHECK(run_raylex(folder, "verify x.exr --sum '[ab]*,a,b'").code == 2);
    CHECK(run_raylex(folder, "verify x.exr --of beauty --sum '?'").code == 0);
    CHECK(run_raylex(folder, "verify x.exr --of RGBA --sum a,b").code == 0);
    CHECK(run_raylex(folder, "verify x.exr --of beauty --sum a").code == 1);
    CHECK(run_raylex(folder, "verify x.exr --of beauty").code == 2);
    Outcome unknown = run_raylex(folder, "verify x.exr --of beauty --sum a,c");
    CHECK(unknown.code == 2);
    CHECK(unknown.err.find("c") != std::string::npos);
    CHECK(run_raylex(folder, "verify x.exr --of nothing --sum a,b").code == 2);
    CHECK(run_raylex(folder, "verify absent.exr").code == 2);
    folder.write("text.exr", "no image");
    CHECK(run_raylex(folder, "verify text.exr").code == 2);
}

TEST_CASE("compare prints one number per metric, equal to the formula") {
    const Folder folder;
    write_image(folder.path("b.exr"), 0, {});
    write_image(folder.path("a.exr"), 0, {}, 1.5);  // a - b is 0.5, 1, 1.5 in R, G, B
    const auto value = [&](const std::string& options) {
        Outcome outcome = run_raylex(folder, "compare a.exr b.exr " + options);
        CAPTURE(options, outcome.err);
        REQUIRE(outcome.code == 0);
        REQUIRE(outcome.out.find('\n') == outcome.out.size() - 1);
        return std::stod(outcome.out);
    };
    // All values are exact in float; nine digits are printed.
    CHECK(value("") == Approx((0.25 / 1.01 + 1 / 4.01 + 2.25 / 9.01) / 3).epsilon(1e-8));
    CHECK(value("--metric mse") == Approx(3.5 / 3).epsilon(1e-8));
    CHECK(value("--metric mse --channel G") == Approx(1).epsilon(1e-8));
    CHECK(value("--metric mae") == Approx(1).epsilon(1e-8));
    CHECK(value("--metric mean-ratio --channel Y") == Approx(1.5).epsilon(1e-7));
    CHECK(value("--metric mse --layer a --channel R") == Approx(0.015625).epsilon(1e-8));
    write_image(folder.path("black.exr"), 0, {}, 0);
    const Outcome none = run_raylex(folder, "compare a.exr black.exr --metric mean-ratio");
    CHECK(none.code == 2);
    CHECK(none.out.empty());
    CHECK(none.err.find("black.exr: there is no ratio mean(a) / mean(b): the mean of 'beauty' is 0") !=
          std::string::npos);
    CHECK(run_raylex(folder, "compare a.exr absent.exr").code == 2);
    CHECK(run_raylex(folder, "compare a.exr b.exr --layer nothing").code == 2);
    CHECK(run_raylex(folder, "compare a.exr b.exr --channel Q").code == 2);
}

TEST_CASE("the page contains every layer, expression and check, and fetches nothing") {
    const Folder folder;
    write_image(folder.path("good.exr"), 0, halves);
    write_image(folder.path("bad <i>.exr"), 1e-3, halves);
    Outcome outcome = run_raylex(folder, "report good.exr 'bad <i>.exr' -o page.html");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const std::string page = folder.read("page.html");
    for (const char* text : {"data-name=\"beauty\"", "data-name=\"a\"", "data-name=\"b\"", "C&lt;RD&gt;SL",
                             "does not hold", "1 of 2 partitions do not hold", "bad &lt;i&gt;.exr"}) {
        CAPTURE(text);
        CHECK(page.find(text) != std::string::npos);
    }
    for (const char* text : {"http:", "https:", "src=\"/", "href=", "@import", "url("}) {
        CAPTURE(text);
        CHECK(page.find(text) == std::string::npos);
    }
    CHECK(run_raylex(folder, "report absent.exr -o page2.html").code == 2);
    CHECK(run_raylex(folder, "report good.exr -o absent/page.html").code == 2);
    CHECK(run_raylex(folder, "report good.exr").code == 2);
    // The page never replaces an image, by any name.
    const std::string image = folder.read("good.exr");
    CHECK(run_raylex(folder, "report good.exr -o good.exr").code == 2);
    CHECK(run_raylex(folder, "report good.exr -o ./good.exr").code == 2);
    CHECK(folder.read("good.exr") == image);
    CHECK_FALSE(folder.has("page2.html"));
    CHECK(folder.read("page.html") == page);
}

TEST_CASE("the page of an image works in a browser", "[gate]") {
    const Folder folder;
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    write_image(folder.path("good.exr"), 0, halves);
    REQUIRE(run_raylex(folder, "report good.exr -o page.html").code == 0);
    // Decoded, and shown through the view.
    const Outcome page = in_browser(folder, "page.html", "1400,900", {"[data-painted=\"0 0 0\"]"});
    CAPTURE(page.err);
    CHECK(page.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(page.out.empty());
    CHECK(page.out.find("<span class=\"share\">25 %</span>") != std::string::npos);
    CHECK(page.out.find("<span class=\"share\">75 %</span>") != std::string::npos);
}
