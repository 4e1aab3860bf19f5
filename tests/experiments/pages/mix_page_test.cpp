// The light mixer in the page of an image, in a real browser.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "tests/experiments/browser.h"
#include "tests/support/skip.h"

using namespace raylex;
using namespace raylex::test;

namespace {

/// The three numbers in the row of a layer, at the pointer.
std::vector<double> values_of(const std::string& page, const std::string& layer) {
    const auto found = all_matches(page, "data-name=\"" + layer + "\"[^]*?<code class=\"value\">([^<]*)</code>");
    REQUIRE_FALSE(found.empty());
    std::istringstream text(found.front()[1]);
    std::vector<double> values(3);
    for (double& value : values) REQUIRE(text >> value);
    return values;
}

}  // namespace

TEST_CASE("the page mixes light groups live, and its file is what raylex mix reads", "[gate]") {
    const SceneFolder folder;
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[[light_group]]\nlight = \"area:0\"\ngroup = \"the lamp\"\n");
    REQUIRE(run_raylex(folder, "render job.toml --light-groups -o a.exr").code == 0);
    REQUIRE(run_raylex(folder, "report a.exr -o page.html").code == 0);
    const std::string page = folder.read("page.html");
    CHECK(contains(page, "\"mix\":"));
    CHECK_FALSE(contains(page, "http://"));
    CHECK_FALSE(contains(page, "https://"));
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    const std::string act = R"(<script>addEventListener('load', () => {
  const panel = document.querySelector('details.mix');
  panel.open = true;
  setTimeout(() => {
    const [other, lit] = panel.querySelectorAll('tr'), set = (input, value) => {
      input.value = value;
      input.dispatchEvent(new Event('input'));
    };
    const press = (row, name) => [...row.querySelectorAll('button')].find(each => each.textContent === name).click();
    set(lit.querySelector('[type=range]'), 1);
    set(lit.querySelector('[type=color]'), '#ff80ff');
    press(other, 'solo');
    document.body.dataset.solo = panel.querySelector('.grade').textContent;
    press(other, 'solo');
    set(other.querySelector('[type=range]'), 3);
    press(other, 'reset');
    press(other, 'mute');
    const canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();
    setTimeout(() => canvas.dispatchEvent(new PointerEvent('pointermove', { clientX: box.left + box.width / 2,
      clientY: box.top + 0.75 * box.height })), 600);
  }, 300);
});</script>)";
    folder.write("acted.html", page + act);
    const Outcome shown = in_browser(folder, "acted.html", "1400,1000", {"[data-name=mix] .value:not(:empty)"});
    CAPTURE(shown.err);
    CHECK(shown.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(shown.out.empty());
    const std::vector<double> lit = values_of(shown.out, "light_default"), mixed = values_of(shown.out, "mix");
    const std::vector<double> factors{2, 2 * 0.215861, 2};
    for (std::size_t c = 0; c < 3; ++c) CHECK(mixed[c] == Approx(factors[c] * lit[c]).epsilon(0.01));
    CHECK(lit[0] > 0);
    CHECK(contains(shown.out, "data-solo=\"light_the_lamp 1 1 1\nlight_default 0 0 0\""));
    const auto toml = all_matches(shown.out, "<pre class=\"toml\">([^<]*)</pre>");
    REQUIRE(toml.size() == 1);
    CHECK(toml[0][1] == "[light]\n\"the lamp\" = [0, 0, 0]\n\"default\" = [2, 0.431721, 2]\n");
    folder.write("mix.toml", toml[0][1]);
    const Outcome made = run_raylex(folder, "mix a.exr --mix mix.toml -o mixed.exr");
    INFO(made.err);
    REQUIRE(made.code == 0);
    const auto image = display::read_exr(folder.path("mixed.exr"));
    REQUIRE(image);
    CHECK(image->attributes.at("raylex/mix") == "default=2,0.431721,2 the lamp=0,0,0");
}

TEST_CASE("the page recolours objects of an atlas as raylex ask does", "[atlas][gate]") {
    const SceneFolder folder;
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[[light_group]]\nlight = \"area:0\"\ngroup = \"key\"\n");
    // The file has a layer for one of the two groups only; the other one comes from the atlas.
    REQUIRE(run_raylex(folder, "render job.toml --lpe light_key=\"C.*<L.'key'>\" -o a.exr --atlas a.atlas.exr").code ==
            0);
    REQUIRE(run_raylex(folder, "report a.exr a.atlas.exr -o page.html").code == 0);
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    const std::string act = R"(<script>addEventListener('load', () => {
  const panel = document.querySelector('details.mix');
  panel.open = true;
  const ready = setInterval(() => {
    if (!document.querySelector('[data-mixed]')) return;
    clearInterval(ready);
    const row = name => [...panel.querySelectorAll('tr')].find(each => each.firstChild.textContent === name);
    const set = (name, type, value) => {
      const input = row(name).querySelector(`[type=${type}]`);
      input.value = value;
      input.dispatchEvent(new Event('input'));
    };
    set('ground.diffuse', 'range', -1);
    set('ground.diffuse', 'color', '#ff80ff');
    set('key', 'range', 1);
    set('default', 'range', -0.5);
    const canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();
    setTimeout(() => canvas.dispatchEvent(new PointerEvent('pointermove', { clientX: box.left + box.width / 2 + 1,
      clientY: box.top + 0.75 * box.height + 1 })), 600);
  }, 50);
});</script>)";
    folder.write("acted.html", folder.read("page.html") + act);
    const Outcome shown = in_browser(folder, "acted.html", "1400,1000", {"[data-name=mix] .value:not(:empty)"});
    CAPTURE(shown.err);
    CHECK(shown.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(shown.out.empty());
    const auto toml = all_matches(shown.out, "<pre class=\"toml\">([^<]*)</pre>");
    REQUIRE(toml.size() == 1);
    CHECK(contains(toml[0][1], "\"default\" = [0.707107, 0.707107, 0.707107]"));
    CHECK(contains(toml[0][1], "[what_if]\n\"ground.diffuse\" = [0.5, 0.10793, 0.5]"));
    folder.write("mix.toml", toml[0][1]);
    const Outcome asked = run_raylex(folder, "ask a.atlas.exr --mix mix.toml -o asked.exr");
    INFO(asked.err);
    REQUIRE(asked.code == 0);
    const auto image = display::read_exr(folder.path("asked.exr"));
    REQUIRE(image);
    const auto at = all_matches(shown.out, "class=\"status\"[^>]*>pixel \\((\\d+), (\\d+)\\)");
    REQUIRE(at.size() == 1);
    const auto pixel = static_cast<std::size_t>(std::stoi(at[0][2]) * image->width + std::stoi(at[0][1]));
    const std::vector<double> mixed = values_of(shown.out, "mix");
    for (std::size_t c = 0; c < 3; ++c) {
        const std::string name(1, "RGB"[c]);
        // The page shows three digits of sums of half floats, and the file has six digits of the factors.
        CHECK(mixed[c] == Approx(plane(*image, "", name)[pixel]).epsilon(0.01));
    }
}
