// --layer and [[layer]]: one channel as several layers of the image.
#include <catch2/catch.hpp>
#include <string>

#include "display/output/reader/exr_reader.h"
#include "support.h"

namespace raylex::test {
namespace {

/// Shown by Catch after a failure; the text is not part of the expression.
}  // namespace

TEST_CASE("a channel feeds several layers, by flag and by job alike", "[cli][layers]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const Outcome flags = run_raylex(
        folder, "render scene.pbrt -o a.exr --aov VLen --layer far=VLen:zmax --layer peak=beauty:max --lpe d='C<RD>L'");
    INFO(flags.err);
    REQUIRE(flags.code == 0);
    folder.write("job.toml",
                 "[scene]\nfile = \"scene.pbrt\"\n[channels]\naovs = [\"VLen\"]\n"
                 "[[channel]]\nname = \"d\"\nlpe = \"C<RD>L\"\n"
                 "[[layer]]\nname = \"far\"\nchannel = \"VLen\"\nrule = \"zmax\"\n"
                 "[[layer]]\nname = \"peak\"\nchannel = \"beauty\"\nrule = \"max\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o b.exr").code == 0);
    const auto a = display::read_exr(folder.path("a.exr")), b = display::read_exr(folder.path("b.exr"));
    REQUIRE(a);
    REQUIRE(b);
    const auto plane = [](const display::ExrImage& image, const char* layer) {
        REQUIRE(image.layer(layer) != nullptr);
        return image.layer(layer)->triple()[0]->values;
    };
    for (const char* layer : {"", "VLen", "far", "peak", "d"}) CHECK(plane(*a, layer) == plane(*b, layer));
    const auto near = plane(*a, "VLen"), far = plane(*a, "far"), mean = plane(*a, ""), peak = plane(*a, "peak");
    bool differs = false;
    for (std::size_t i = 0; i < near.size(); ++i) {
        CHECK(near[i] <= far[i]);
        CHECK(mean[i] <= peak[i]);
        differs = differs || near[i] < far[i];
    }
    CHECK(differs);
    CHECK(a->attributes.at("source/far") == "VLen");
    CHECK(a->attributes.at("rule/far") == "zmax");
    // Requesting layers changes nothing else (Law 2).
    REQUIRE(run_raylex(folder, "render scene.pbrt -o c.exr").code == 0);
    CHECK(plane(*display::read_exr(folder.path("c.exr")), "") == mean);
}

TEST_CASE("invalid layers are refused before rendering", "[cli][layers][law7]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const auto says = [&](const std::string& arguments, const std::string& message) {
        const Outcome outcome = run_raylex(folder, "render scene.pbrt -o a.exr " + arguments);
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, message));
        CHECK_FALSE(folder.has("a.exr"));
    };
    says("--layer z_far", "'z_far' is not a setting");
    says("--layer z_far=z", "has no rule");
    says("--layer z_far=z:zmxa", "did you mean 'zmax'?");
    says("--aov z --layer far=Z:zmax", "unknown channel 'Z'");
    says("--aov z --layer z=beauty:max", "'z' is taken");
    says("--layer 'a b=beauty:max'", "cannot be a channel name");
    folder.write("job.toml",
                 "[scene]\nfile = \"scene.pbrt\"\n[[layer]]\nname = \"x\"\nchannel = \"beauty\"\nrul = \"max\"\n");
    const Outcome job = run_raylex(folder, "render job.toml -o a.exr");
    CHECK(job.code == 2);
    CHECK(contains(job.err, "job.toml:"));
}

}  // namespace raylex::test
