// --plugin and `raylex plugins`: which plugins are loaded or refused, and why. tests/outside/check_plugins.cpp checks
// out of tree how the example plugins change an image.
#include <algorithm>
#include <catch2/catch.hpp>

#include <fstream>
#include <string>

#include "support.h"
#include "tests/support/paths.h"
#include "transport/plugins/plugin_file.h"

namespace raylex::test {
namespace {

/// Shown by Catch after a failure; the text is not part of the expression.
using transport::PluginStamp;

std::string plugin_path(const std::string& name) {
    return binary_dir() + "/tests/lib" + name + ".so";
}
std::string quoted(const std::string& path) {
    return "'" + path + "'";
}

std::string file_text(const std::string& path) {
    const Folder folder;
    return run_shell(folder, "cat " + quoted(path)).out;
}

/// Returns a copy of the plugin in which the byte at `offset` in its stamp is changed.
std::string with_other_stamp(const Folder& folder, const std::string& name, std::size_t offset) {
    std::string bytes = file_text(plugin_path(name));
    const std::size_t stamp = bytes.find(std::string(PluginStamp::magic_text) + '\0');
    REQUIRE(stamp != std::string::npos);
    bytes[stamp + offset] = static_cast<char>(bytes[stamp + offset] + 1);
    return folder.write("other_" + std::to_string(offset) + ".so", bytes);
}

}  // namespace

TEST_CASE("`raylex plugins` lists what a plugin registers, with every parameter", "[cli][plugins][gate]") {
    const Folder folder;
    const Outcome listed = run_raylex(
        folder, "plugins " + quoted(plugin_path("ambient_occlusion")) + " " + quoted(plugin_path("stripes")));
    CHECK(listed.code == 0);
    CHECK(contains(listed.out, "integrator ambientocclusion: the share of the sky that a point sees"));
    CHECK(contains(listed.out, "float maxdistance = infinite: how far"));
    CHECK(contains(listed.out, "texture stripes: alternates two textures along u"));
    CHECK(contains(listed.out, "integer count = 8:"));
    const Outcome in_tree = run_raylex(folder, "plugins");
    CHECK(in_tree.code == 0);
    for (const char* name : {"integrator path:", "camera perspective:", "material diffuse:", "texture imagemap:",
                             "shape trianglemesh:", "sample filter clamp:", "display driver png:"})
        CHECK(contains(in_tree.out, name));
    CHECK(in_tree.out.find("ambientocclusion") == std::string::npos);
}

TEST_CASE("a plugin's integrator renders a scene that names it", "[cli][plugins][gate]") {
    const Folder folder;
    std::string scene = small_scene();
    const std::string path = "Integrator \"path\" \"integer maxdepth\" 3";
    REQUIRE(scene.find(path) != std::string::npos);
    const std::string occlusion = "Integrator \"ambientocclusion\" \"float maxdistance\" 3";
    folder.write("scene.pbrt", scene.replace(scene.find(path), path.size(), occlusion));
    const std::string with = "render scene.pbrt -o out.exr --plugin " + quoted(plugin_path("ambient_occlusion"));
    const Outcome rendered = run_raylex(folder, with + " --stats out.json");
    INFO(rendered.err);
    CHECK(rendered.code == 0);
    CHECK(rendered.err.find("not available") == std::string::npos);
    CHECK(contains(folder.read("out.json"), "\"raylex/plugins\""));
    CHECK(contains(folder.read("out.json"), "libambient_occlusion.so"));
    const Outcome fallback = run_raylex(folder, "render scene.pbrt -o out.exr");
    CHECK(contains(fallback.err, "'ambientocclusion' is not available"));
    // Two flags with the same plugin load it once.
    CHECK(run_raylex(folder, with + " --plugin " + quoted(plugin_path("ambient_occlusion"))).code == 0);
    folder.write("job.toml",
                 "plugins = [\"" + plugin_path("ambient_occlusion") + "\"]\n[scene]\nfile = \"scene.pbrt\"\n");
    CHECK(run_raylex(folder, "render job.toml -o out.exr").code == 0);
    CHECK(run_raylex(folder, "lpe check --scene job.toml all='C.*'").code == 0);
}

TEST_CASE("a plugin's factory that returns nothing, or throws, ends a render with a message", "[cli][plugins][gate]") {
    const SceneFolder folder;
    const std::string render = "\"$RAYLEX\" render room.pbrt --spp 1 -o out.exr --driver halfway:a=1 --plugin " +
                               quoted(plugin_path("misbehaving"));
    for (const auto& [how, what] : {std::pair<std::string, std::string>{
                                        "null-driver", "the plugin's display driver 'halfway' was a null pointer"},
                                    {"number-driver", "it threw an object that is not a std::exception"}}) {
        const Outcome outcome = run_shell(folder, "MISBEHAVIOUR=" + how + " " + render);
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, what));
    }
}

TEST_CASE("a missing plugin of a job is an error with file, line and column", "[cli][plugins][law7][gate]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    folder.write("job.toml", "# plugins\nplugins = [\n  \"missing.so\"]\n[scene]\nfile = \"scene.pbrt\"\n");
    const Outcome outcome = run_raylex(folder, "render job.toml -o out.exr");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "job.toml:3:4: cannot read plugin"));
    CHECK(contains(outcome.err, "missing.so': cannot read this file: No such file"));
    CHECK_FALSE(folder.has("out.exr"));
}

TEST_CASE("a file that is not a plugin is refused before it is opened", "[cli][plugins][law7][gate]") {
    const Folder folder;
    folder.write("text.so", "#!/bin/sh\ntouch ran\n");
    folder.write("empty.so", "");
    const auto says = [&](const std::string& file, const std::string& message) {
        const Outcome outcome = run_raylex(folder, "plugins " + file);
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, message));
    };
    says(".", "is a directory");
    says("missing.so", "No such file");
    says("text.so", "is not a shared library");
    says("empty.so", "is not a shared library");
    // A shared library without a stamp section: the C library of this process.
    std::ifstream maps("/proc/self/maps");
    std::string library;
    for (std::string line; library.empty() && std::getline(maps, line);)
        if (line.find("/libc.so") != std::string::npos) library = line.substr(line.find('/'));
    REQUIRE_FALSE(library.empty());
    says(test::quoted(library), "not a raylex plugin");
}

TEST_CASE("a plugin with any difference in its stamp is refused, and the difference is named",
          "[cli][plugins][law7][gate]") {
    const Folder folder;
    const auto says = [&](std::size_t offset, const std::string& message) {
        const Outcome outcome = run_raylex(folder, "plugins " + quoted(with_other_stamp(folder, "stripes", offset)));
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, message));
    };
    says(0, "a stamp in another format");
    says(offsetof(PluginStamp, version), "was built for raylex 1.");
    says(offsetof(PluginStamp, compiler), "was built by h++");
    says(offsetof(PluginStamp, standard_library), "was built with mibstdc++");
    says(offsetof(PluginStamp, interface), "other headers");
    says(offsetof(PluginStamp, layout), "std::string has 33 bytes in it and 32 in this program");
}

TEST_CASE("a truncated plugin is refused", "[plugins][law7][gate]") {
    const Folder folder;
    const std::string bytes = file_text(plugin_path("stripes"));
    REQUIRE(transport::read_plugin_stamp(plugin_path("stripes"), {}));
    // Debug builds are large: about 64 truncations, and every one through the first header.
    for (std::size_t size = 0; size < bytes.size(); size += size < 64 ? 7 : bytes.size() / 64) {
        INFO(size);
        const auto stamp = transport::read_plugin_stamp(folder.write("cut.so", bytes.substr(0, size)), {});
        CHECK_FALSE(stamp);
    }
}

TEST_CASE("a plugin that fails during registration is named and leaves nothing registered",
          "[cli][plugins][law7][gate]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const auto says = [&](const std::string& kind, const std::string& name, const std::string& message) {
        const Outcome outcome =
            run_shell(folder, "MISBEHAVIOUR=" + kind + " \"$RAYLEX\" render scene.pbrt -o out.exr --plugin " +
                                  quoted(plugin_path(name)));
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, "--plugin: plugin '"));
        CHECK(contains(outcome.err, message));
        CHECK_FALSE(folder.has("out.exr"));
    };
    says("exception", "misbehaving", "it threw while registering: no licence for this machine");
    says("number", "misbehaving", "it threw an object that is not a std::exception");
    says("refusal", "misbehaving", "it needs a graphics card");
    says("twice", "misbehaving", "it registers the display driver 'halfway' twice");
    says("nothing", "misbehaving", "registered nothing");
    says("", "unbound", "undefined symbol: raylex_not_defined_anywhere");
}

TEST_CASE("a plugin may replace an in-tree object, but not that of another plugin", "[cli][plugins][gate]") {
    const Folder folder;
    const std::string shadowing = quoted(plugin_path("misbehaving"));
    const Outcome listed = run_shell(folder, "MISBEHAVIOUR=shadow \"$RAYLEX\" plugins " + shadowing);
    CHECK(listed.code == 0);
    CHECK(contains(listed.out, "display driver exr (instead of the in-tree one)"));
    folder.write("copy.so", file_text(plugin_path("misbehaving")));
    const Outcome twice = run_raylex(folder, "plugins " + shadowing + " copy.so");
    CHECK(twice.code == 2);
    CHECK(contains(twice.err, "another plugin has registered the display driver 'halfway' already"));
}

TEST_CASE("the integrator in the documentation is the file that is compiled and run", "[plugins][readme][gate]") {
    const std::string root = source_dir();
    const std::string source = file_text(root + "/tests/outside/plugins/ambient_occlusion.cpp");
    REQUIRE(source.find("RAYLEX_PLUGIN(host)") != std::string::npos);
    CHECK(file_text(root + "/experiments/docs/extending.md").find("```cpp\n" + source + "```\n") != std::string::npos);
}

}  // namespace raylex::test
