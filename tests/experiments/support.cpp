#include "support.h"
#include "tests/support/paths.h"

#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace raylex::test {
namespace {

namespace fs = std::filesystem;

std::string file_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// For messages of the shell that runs a command: outside the folder that tests look into.
std::string sibling(const Folder& folder, const std::string& suffix) {
    return folder.path() + suffix;
}

}  // namespace

Folder::Folder() {
    std::string pattern = (fs::temp_directory_path() / "raylex test XXXXXX").string();  // a space, as users have them
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a folder for the test");
    path_ = pattern;
}

Folder::~Folder() {
    std::error_code failed;
    fs::remove_all(path_, failed);
}

std::string Folder::path(const std::string& name) const {
    return name.empty() ? path_ : path_ + "/" + name;
}

std::string Folder::write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
}

bool Folder::has(const std::string& name) const {
    return fs::exists(path(name));
}

std::string Folder::read(const std::string& name) const {
    return file_text(path(name));
}

std::vector<std::string> Folder::names() const {
    std::vector<std::string> result;
    for (const auto& entry : fs::directory_iterator(path_)) result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
}

Outcome run_shell(const Folder& folder, const std::string& line) {
    const std::string script = sibling(folder, ".sh"), out = sibling(folder, ".out"), err = sibling(folder, ".err");
    std::ofstream(script) << "cd '" << folder.path() << "' || exit 99\nRAYLEX='" << raylex::test::binary_dir() << "/raylex'\n"
                          << line << "\n";
    const int status = std::system(("bash '" + script + "' >'" + out + "' 2>'" + err + "' </dev/null").c_str());
    Outcome outcome;
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.out = file_text(out);
    outcome.err = file_text(err);
    for (const std::string& file : {script, out, err}) std::remove(file.c_str());
    return outcome;
}

Outcome run_raylex(const Folder& folder, const std::string& arguments) {
    return run_shell(folder, "exec \"$RAYLEX\" " + arguments);
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
