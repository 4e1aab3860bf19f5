#include "support.h"

#include <catch2/catch.hpp>

#include "tests/support/paths.h"

#include <sys/wait.h>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <regex>

namespace raylex::test {
namespace {

/// A file for messages of the shell that runs a command, outside the folder that tests inspect.
std::string sibling(const Folder& folder, const std::string& suffix) {
    return folder.path() + suffix;
}

}  // namespace

Outcome run_shell(const Folder& folder, const std::string& line) {
    const std::string script = sibling(folder, ".sh"), out = sibling(folder, ".out"), err = sibling(folder, ".err");
    std::ofstream(script) << "cd '" << folder.path() << "' || exit 99\nRAYLEX='" << raylex::test::binary_dir()
                          << "/raylex'\n"
                          << line << "\n";
    const int status = std::system(("bash '" + script + "' >'" + out + "' 2>'" + err + "' </dev/null").c_str());
    Outcome outcome;
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.out = read_bytes(out);
    outcome.err = read_bytes(err);
    for (const std::string& file : {script, out, err}) std::remove(file.c_str());
    return outcome;
}

Outcome run_raylex(const Folder& folder, const std::string& arguments) {
    return run_shell(folder, "exec \"$RAYLEX\" " + arguments);
}

void check_refused(const Folder& folder, const std::string& arguments, const std::vector<std::string>& words) {
    CAPTURE(arguments);
    const std::vector<std::string> before = folder.names();
    const Outcome outcome = run_raylex(folder, arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 2);
    for (const std::string& word : words) {
        CAPTURE(word);
        CHECK(outcome.err.find(word) != std::string::npos);
    }
    CHECK(folder.names() == before);
}

bool contains(const std::string& text, const std::string& part) {
    UNSCOPED_INFO(text);
    return text.find(part) != std::string::npos;
}

bool matches(const std::string& text, const std::string& pattern) {
    return std::regex_match(text, std::regex(pattern));
}

std::vector<std::vector<std::string>> all_matches(const std::string& text, const std::string& pattern) {
    const std::regex wanted(pattern);
    std::vector<std::vector<std::string>> found;
    for (std::sregex_iterator at(text.begin(), text.end(), wanted), end; at != end; ++at)
        found.emplace_back(at->begin(), at->end());
    return found;
}

std::size_t count_matches(const std::string& text, const std::string& pattern) {
    return all_matches(text, pattern).size();
}

std::vector<float> plane(const display::ExrImage& image, const std::string& layer, const std::string& name) {
    CAPTURE(layer, name);
    REQUIRE(image.layer(layer) != nullptr);
    REQUIRE(image.layer(layer)->plane(name) != nullptr);
    return image.layer(layer)->plane(name)->values;
}

std::string image_bits(const std::string& path) {
    auto image = display::read_exr(path);
    INFO((image ? std::string() : image.error().to_string()));
    REQUIRE(image);
    std::string bits;
    for (const auto& layer : image->layers)
        for (const auto& each : layer.planes) {
            bits += layer.name + "." + each.name + ":";
            bits.append(reinterpret_cast<const char*>(each.values.data()), each.values.size() * sizeof(float));
        }
    return bits;
}

std::string small_scene() {
    return R"(Film "rgb" "integer xresolution" 16 "integer yresolution" 16
Sampler "independent" "integer pixelsamples" 4
Integrator "path" "integer maxdepth" 3
LookAt 0 1 4  0 1 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "point" "rgb I" [3 3 3] "point3 from" [0 2 1]
MakeNamedMaterial "ground" "string type" "diffuse" "rgb reflectance" [.5 .4 .3]
NamedMaterial "ground"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 2 2 0 2 2 0 -2 -2 0 -2]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [4 4 4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-.5 2 -1 .5 2 -1 .5 1.5 -1 -.5 1.5 -1]
AttributeEnd
)";
}

}  // namespace raylex::test
