// raylex ask --top without a pixel: lists the outliers of an image and their paths.
#include <catch2/catch.hpp>

#include <algorithm>

#include "tests/experiments/support.h"

using namespace raylex;
using namespace raylex::test;

TEST_CASE("the brightest outliers of an image are listed with their paths, in order", "[atlas]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder, "render room.pbrt --atlas a.atlas.exr -o a.exr").code == 0);
    const Outcome outliers = run_raylex(folder, "ask a.atlas.exr --top 5");
    INFO(outliers.out << outliers.err);
    REQUIRE(outliers.code == 0);
    CHECK(count_matches(outliers.out, "pixel \\([0-9]+, [0-9]+\\): .*, mean ") == 5);
    CHECK(count_matches(outliers.out, "\n  [0-9.]+ % +[0-9.e-]+ \\+- [0-9.e-]+ +C [RTLBO]") >= 5);
    auto image = display::read_exr(folder.path("a.exr"));
    REQUIRE(image);
    const auto red = plane(*image, "", "R"), green = plane(*image, "", "G"), blue = plane(*image, "", "B");
    const auto above = [&](int x, int y) {
        const auto mean = [&](int u, int v) {
            const auto i = static_cast<std::size_t>(v * image->width + u);
            return (red[i] + green[i] + blue[i]) / 3;
        };
        std::vector<float> around;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, image->height - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, image->width - 1); ++u)
                if (u != x || v != y) around.push_back(mean(u, v));
        std::sort(around.begin(), around.end());
        return mean(x, y) - around[around.size() / 2];
    };
    std::vector<float> all, listed;
    for (int y = 0; y < image->height; ++y)
        for (int x = 0; x < image->width; ++x) all.push_back(above(x, y));
    for (const auto& found : all_matches(outliers.out, "pixel \\(([0-9]+), ([0-9]+)\\)"))
        listed.push_back(above(std::stoi(found[1]), std::stoi(found[2])));
    std::sort(all.rbegin(), all.rend());
    CHECK(listed == std::vector<float>(all.begin(), all.begin() + 5));
    check_refused(folder, "ask a.atlas.exr --at 4,6", {"--at", "--top"});
}
