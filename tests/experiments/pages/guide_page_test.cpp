// What a guide learned, in the statistics and in the page of an image.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "experiments/report/guide/guide_view.h"
#include "tests/experiments/browser.h"
#include "tests/experiments/pages/unpacked.h"
#include "tests/support/skip.h"
#include "transport/paths/guide/guide_sums.h"

using namespace raylex;
using namespace raylex::test;
using experiments::Json;
using transport::GuideTree;
using transport::GuideView;

namespace {

/// A view of 4 x 3 points of a tree that learned different directions in several regions. One point has no region.
GuideView view_of_some() {
    GuideTree tree(transport::Bounds{{0, 0, 0}, {1, 1, 1}});
    for (int round = 0; round < 3; ++round) {
        transport::GuideSums sums(tree);
        for (std::uint64_t i = 0; i < 4000; ++i) {
            const auto at = [i](std::uint64_t prime) { return static_cast<transport::Real>(i * prime % 1000) / 1000; };
            sums.add({.position = {at(7), at(11), at(13)},
                      .normal = {0, 1, 0},
                      .direction = normalize(transport::Vec3{at(7), 1 + at(17), at(19) - at(11)}),
                      .square = 1 + static_cast<double>(i % 5),
                      .density = 0.1,
                      .chance = 0.1,
                      .key = i});
        }
        tree = refined(sums, {.finds = 1500, .nodes = 100'000});
    }
    GuideView view{.tree = std::move(tree)};
    view.step = 2;
    view.width = 4;
    view.height = 3;
    const auto count = static_cast<std::uint32_t>(view.tree.regions().size());
    REQUIRE(count > 9);
    view.regions = {0, 1, 2, 2, GuideView::no_region, 5, 6, 7, count - 1, 2, 8, 3};
    return view;
}

}  // namespace

TEST_CASE("the view of a guide has each region once, with a map that integrates to 1", "[report][guide]") {
    const GuideView view = view_of_some();
    const Json json = experiments::guide_view_json(view);
    CHECK((json["step"] == 2 && json["width"] == 4 && json["height"] == 3));
    constexpr std::size_t regions = 9, cells = 32 * 32;
    REQUIRE(json["probabilities"].size() == regions);
    const std::vector<unsigned char> points = unpacked(json["points"], 4 * view.regions.size());
    const std::vector<unsigned char> maps = unpacked(json["maps"], regions * cells);
    std::size_t divided = 0;
    for (std::size_t i = 0; i < view.regions.size(); ++i) {
        const std::size_t number = points[3 * view.regions.size() + i];
        CHECK((number == 0) == (view.regions[i] == GuideView::no_region));
        if (number == 0) continue;
        CHECK((number == 1) == (view.regions[i] == 2));  // the region of most points comes first
        CHECK(json["probabilities"][number - 1] == Approx(double{view.share(i)}).margin(5e-5));  // four decimals
        const auto shares = view.tree.shares_of_cells(view.tree.regions()[view.regions[i]], 5);
        double sum = 0;
        for (std::size_t cell = 0; cell < cells; ++cell) {
            const int byte = maps[(number - 1) * cells + cell];
            const double share = byte == 0 ? 0 : std::exp2((byte - 128) / 10.0) / cells;
            // A step is a tenth of an octave, and bytes are rounded.
            CHECK(share == Approx(double{shares[cell]}).epsilon(std::exp2(0.05) - 1 + 1e-6));
            sum += share;
            divided += shares[cell] > 1.0 / 256 ? 1 : 0;
        }
        CHECK(sum == Approx(1).epsilon(std::exp2(0.05) - 1 + 1e-6));
    }
    CHECK(divided > 20);
}

TEST_CASE("a page takes the view of a guide from the statistics of an image of its size", "[report][guide]") {
    Json record;
    record["guide"]["view"] = experiments::guide_view_json(view_of_some());
    const auto html = [&](int width, int height) { return experiments::guide_view_html(record.dump(), width, height); };
    for (const int width : {7, 8})
        for (const int height : {5, 6}) CHECK(contains(html(width, height), "class=\"guide\""));
    CHECK(html(9, 5).empty());
    CHECK(html(7, 4).empty());
    record["guide"]["view"]["maps"] = "</script><b>";
    CHECK_FALSE(contains(html(8, 6), "</script><b>"));
    for (const char* step : {"0", "-2", "1.5", "\"2\"", "null"}) {
        record["guide"]["view"]["step"] = experiments::parse_json(step);
        CHECK(html(8, 6).empty());
    }
    CHECK(experiments::guide_view_html("{\"guide\": 3}", 8, 6).empty());
    CHECK(experiments::guide_view_html("no JSON", 8, 6).empty());
}

TEST_CASE("the page shows where a guide is used, and the directions of a clicked point", "[gate]") {
    const Folder folder;
    folder.write("room.pbrt", R"(Film "rgb" "integer xresolution" 48 "integer yresolution" 48
Sampler "independent"
LookAt 2.4 2 3.4  0 0 0.3  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "bilinearmesh" "point3 P" [-1 0 4 1 0 4 -1 0 -1 1 0 -1]
Shape "bilinearmesh" "point3 P" [-1 0 -1 1 0 -1 -1 2 -1 1 2 -1]
AttributeBegin Translate -0.7 1.5 0.2
  AttributeBegin Material "dielectric" Shape "sphere" "float radius" 0.2 AttributeEnd
  AreaLightSource "diffuse" "rgb L" [60 60 60]
  Shape "sphere" "float radius" 0.12
AttributeEnd
)");
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[integrator]\ntype = \"path\"\nguide = \"on\"\nguidesamples = 256\n");
    const Outcome rendered = run_raylex(folder, "render job.toml --spp 4 -o a.exr --stats a.json");
    INFO(rendered.err);
    REQUIRE(rendered.code == 0);
    CHECK(matches(rendered.out + rendered.err, "[^]*guide: 256 samples[^]* regions and in [0-9.]+ % of the image[^]*"));
    const Json guide = experiments::parse_json(folder.read("a.json"))["guide"], paid = guide["paid"];
    CHECK((paid["image_share"] > 0 && paid["image_share"] <= 1));
    CHECK((paid["image_probability"] > 0 && paid["image_probability"] <= 0.9 * paid["image_share"].get<double>()));
    std::uint64_t regions = 0, sides = 0, guided = 0;
    for (const Json& count : paid["regions"]) regions += count.get<std::uint64_t>();
    for (const Json& side : paid["sides"]) {
        sides += side["regions"].get<std::uint64_t>();
        guided += side["guided"].get<std::uint64_t>();
    }
    CHECK((regions == guide["regions"] && sides == regions));
    CHECK(static_cast<double>(guided) == Approx(guide["guided_share"].get<double>() * static_cast<double>(regions)));
    CHECK(paid["sides"]["media"] == Json{{"regions", 1}, {"guided", 0}});
    const Outcome piped = run_raylex(folder, "render job.toml --spp 4 -o b.exr --stats -");
    CHECK((contains(piped.out, "\"paid\"") && !contains(piped.out, "\"view\"")));

    REQUIRE(run_raylex(folder, "report a.exr -o page.html").code == 0);
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    // A click on the floor, in the middle of the picture. Of the discs' pixels the one of the lightest colour has the
    // most density.
    const std::string act = R"(<script>addEventListener('load', () => {
  const section = document.querySelector('section'), panel = document.querySelector('details.guide');
  panel.open = true;
  const canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();
  const at = { bubbles: true, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
  const act = setInterval(() => {
    if (!canvas.dataset.painted || canvas.dataset.painted === '0 0 0') return;
    canvas.dispatchEvent(new PointerEvent('pointermove', at));
    canvas.dispatchEvent(new MouseEvent('click', at));
    if (!section.dataset.guide) return;
    clearInterval(act);
    let most = -1;
    panel.querySelectorAll('.spheres canvas').forEach((disc, k) => {
      const { data, width } = disc.getContext('2d').getImageData(0, 0, disc.width, disc.height);
      for (let i = 0; i < width * width; ++i) {
        const light = data[4 * i] + 2 * data[4 * i + 1];
        if (light <= most) continue;
        most = light;
        const u = (i % width + 0.5) * 2 / width - 1, v = 1 - (Math.floor(i / width) + 0.5) * 2 / width;
        section.dataset.most = `${u} ${v} ${k}`;
      }
    });
  }, 200);
});</script>)";
    folder.write("acted.html", folder.read("page.html") + act);
    const Outcome shown =
        in_browser(folder, "acted.html", "1400,1000", {"section[data-most]", "[data-name=guide] .value:not(:empty)"});
    CAPTURE(shown.err);
    CHECK(shown.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(shown.out.empty());
    CHECK(contains(shown.out, "the guide draws a direction with probability 0."));
    const auto found = all_matches(shown.out, "data-most=\"([^\"]*)\"");
    REQUIRE(found.size() == 1);
    std::istringstream text(found[0][1]);
    double u = 0, v = 0;
    int into_picture = 0;
    REQUIRE(text >> u >> v >> into_picture);
    const double angle = std::hypot(u, v) * std::acos(0.0), sine = std::sin(angle) / std::hypot(u, v);
    const double z = (into_picture == 1 ? 1 : -1) * std::cos(angle);
    // Camera space as pbrt's LookAt defines it, and the way from the floor to the lamp.
    const transport::Vec3 ahead = normalize(transport::Vec3{-2.4f, -2, -3.1f});
    const transport::Vec3 right = normalize(cross(transport::Vec3{0, 1, 0}, ahead)), up = cross(ahead, right);
    const transport::Vec3 lamp = normalize(transport::Vec3{-0.7f, 1.5f, -0.1f});
    // The map's cells of 6 to 14 degrees are wider than the globe, and the region is a part of the floor.
    CHECK(u * sine * dot(right, lamp) + v * sine * dot(up, lamp) + z * dot(ahead, lamp) > std::cos(0.35));
}
