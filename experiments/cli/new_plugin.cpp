// raylex new plugin: writes a project that builds a plugin, renders with it and tests it.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>

#include "experiments/cli/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/templates/templates.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

struct NewPlugin {
    std::string name, kind = "integrator", folder;
};

std::string with_name(std::string text, const std::string& name) {
    const std::string mark = "@NAME@";
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += name.size())
        text.replace(at, mark.size(), name);
    return text;
}

constexpr const char* project_text =
    R"text(# cmake -S . -B build && cmake --build build && ctest --test-dir build --output-on-failure
# If raylex is not installed in the system, add -DCMAKE_PREFIX_PATH=PREFIX to the first command.
cmake_minimum_required(VERSION 3.25)
project(@NAME@ LANGUAGES CXX)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
find_package(raylex REQUIRED COMPONENTS plugin)
raylex_add_plugin(@NAME@ @NAME@.cpp)
enable_testing()
add_test(NAME @NAME@
         COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/test.sh $<TARGET_FILE:raylex::raylex> $<TARGET_FILE:@NAME@>)
)text";

constexpr const char* scene_text = R"text(LookAt 0 1 6  0 0.8 0  0 1 0
Camera "perspective" "float fov" 30
Film "rgb" "integer xresolution" 96 "integer yresolution" 64
Sampler "zsobol" "integer pixelsamples" 64
WorldBegin
LightSource "infinite" "rgb L" [0.4 0.5 0.6]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 7 6]
  Translate -1 2.2 0.5 Shape "sphere" "float radius" 0.2
AttributeEnd
@SURFACE@
Translate 0 0.6 0 Shape "sphere" "float radius" 0.6
Translate 0 -0.6 0 Shape "bilinearmesh" "point3 P" [-3 0 -2  3 0 -2  -3 0 2  3 0 2]
)text";

/// The parts of the generated scene and of its render command that depend on the kind of plugin.
struct Use {
    const char *kind, *surface, *options, *channels;
};
constexpr Use uses[] = {
    {"integrator", "Material \"diffuse\" \"rgb reflectance\" [0.6 0.5 0.4]", "--integrator @NAME@",
     "--aov @NAME@_bounces,@NAME@_glow,@NAME@_glow_again,Nn,z"},
    {"pattern",
     "Texture \"stripes\" \"spectrum\" \"@NAME@\" \"rgb tex1\" [0.7 0.2 0.1] \"rgb tex2\" [0.2 0.3 0.7]\n"
     "Material \"diffuse\" \"texture reflectance\" \"stripes\"",
     "", "--aov @NAME@_stripe"},
    {"material", "Material \"@NAME@\" \"rgb reflectance\" [0.6 0.5 0.4]", "", ""},
    {"filter", "Material \"diffuse\" \"rgb reflectance\" [0.6 0.5 0.4]", "--sample-filter @NAME@:stops=1", ""},
    {"driver", "Material \"diffuse\" \"rgb reflectance\" [0.6 0.5 0.4]", "--driver @NAME@:file=out.pfm", ""},
};

constexpr const char* test_text = R"text(#!/usr/bin/env bash
# Renders the scene with the plugin: all calls are accepted, all channels are written, and the layers sum to beauty.
#   bash test.sh RAYLEX PLUGIN.so
set -euo pipefail
raylex=$1 plugin=$2
scene=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/scene.pbrt
cd "$(mktemp -d)"
"$raylex" render "$scene" --plugin "$plugin" @OPTIONS@ @CHANNELS@ --partition shipped -o out.exr 2>messages ||
  { cat messages; exit 1; }
if grep -E 'refused|is empty' messages; then exit 1; fi
"$raylex" verify out.exr
)text";
constexpr const char* comparison_text =
    R"text(# The integrator must agree with `path`. The relmse between two images of 64 samples is noise;
# 0.005 is five times that of this scene.
"$raylex" render "$scene" -o path.exr
"$raylex" compare out.exr path.exr --metric relmse | tee comparison
awk '{ found = 1; if ($NF + 0 > 0.005) exit 1 } END { exit !found }' comparison
)text";

Status check_name(const std::string& name) {
    const bool fits = !name.empty() && std::islower(static_cast<unsigned char>(name.front())) &&
                      std::all_of(name.begin(), name.end(),
                                  [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '_'; });
    if (fits) return success();
    return error_at(
        {}, "'" + name +
                "' is not a valid plugin name; expected lower-case letters, digits and _, beginning with a letter");
}

int make_plugin(const NewPlugin& wanted) {
    if (Status s = check_name(wanted.name); !s) return report_error(s.error());
    const auto& use =
        *std::find_if(std::begin(uses), std::end(uses), [&](const Use& u) { return u.kind == wanted.kind; });
    const fs::path folder = wanted.folder.empty() ? fs::path(wanted.name) : fs::path(wanted.folder);
    std::error_code failed;
    if (fs::exists(folder, failed))
        return report_error("'" + folder.string() + "' exists already; expected a new folder (-o FOLDER)");
    fs::create_directories(folder, failed);
    if (failed) return report_error("cannot make the folder '" + folder.string() + "': " + failed.message());
    const auto filled = [&](std::string text) {
        const auto replace = [&](const std::string& mark, const std::string& by) {
            if (const std::size_t at = text.find(mark); at != std::string::npos) text.replace(at, mark.size(), by);
        };
        replace("@SURFACE@", use.surface);
        replace("@OPTIONS@", use.options);
        replace("@CHANNELS@", use.channels);
        return with_name(std::move(text), wanted.name);
    };
    const std::string test = wanted.kind == "integrator" ? std::string(test_text) + comparison_text : test_text;
    for (const auto& [file, text] : {std::pair<std::string, std::string>{"CMakeLists.txt", project_text},
                                     {wanted.name + ".cpp", std::string(plugin_template(wanted.kind))},
                                     {"scene.pbrt", scene_text},
                                     {"test.sh", test}})
        if (Status s = write_text((folder / file).string(), filled(text)); !s) return report_error(s.error());
    print_line(folder.string() + ": a plugin with " + (use.kind == std::string("integrator") ? "an " : "a ") +
               use.kind + " called '" + wanted.name + "'. Build and test it:");
    print_line("  cmake -S " + folder.string() + " -B " + folder.string() + "/build && cmake --build " +
               folder.string() + "/build && ctest --test-dir " + folder.string() + "/build --output-on-failure");
    print_line("Then: raylex render " + folder.string() + "/scene.pbrt --plugin " + folder.string() + "/build/lib" +
               wanted.name + ".so " + with_name(use.options, wanted.name));
    return exit_holds;
}

}  // namespace

void add_new_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand("new", "Starts a project that uses raylex.");
    command->require_subcommand(1);
    CLI::App* plugin = command->add_subcommand(
        "plugin", "Writes a project that builds a plugin and renders with it. Its test passes as generated.");
    auto wanted = std::make_shared<NewPlugin>();
    plugin->add_option("NAME", wanted->name, "name of the plugin and of the type that it registers")
        ->required()
        ->option_text("(required)");
    plugin->add_option("--kind", wanted->kind, "integrator (default), pattern, material, filter or driver")
        ->option_text("KIND")
        ->check(CLI::IsMember(std::vector<std::string>(plugin_kinds.begin(), plugin_kinds.end())));
    plugin->add_option("-o,--output", wanted->folder, "new folder for the project; default: NAME")
        ->option_text("FOLDER");
    plugin->footer("experiments/docs/plugins.md describes the calls that a plugin makes.");
    plugin->callback([wanted, &context] { context.exit_code = make_plugin(*wanted); });
}

}  // namespace raylex::experiments
