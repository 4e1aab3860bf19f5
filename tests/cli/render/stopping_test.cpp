// Signals and the time limit end the program in every phase within about a second, and never by an abort.
#include <catch2/catch.hpp>

#include <chrono>
#include <csignal>
#include <string>

#include "support.h"

using namespace raylex::test;

namespace {

/// Light is never lost in a box without a hole.
std::string endless_scene() {
    return R"(Film "rgb" "integer xresolution" 16 "integer yresolution" 16
Integrator "path" "integer maxdepth" 1000000 "bool roulette" false
LookAt 0 0 0  0 0 1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
LightSource "point" "rgb I" [1 1 1] "point3 from" [0 0.5 0]
Material "diffuse" "rgb reflectance" [1 1 1]
Shape "sphere" "float radius" 2
)";
}

/// Sends `signal` to the program some time after its handlers are installed (before that, the shell decides). Returns
/// its exit code and the time it took to end. A program that does not end is killed after a minute.
struct Stopped {
    Outcome outcome;
    double seconds = 0;
};
Stopped stop_by(const Folder& folder, const std::string& arguments, const std::string& signal, double after) {
    Stopped stopped{run_shell(folder, "\"$RAYLEX\" " + arguments + R"( & raylex=$!
            # SIGTERM is bit 14 of the signals caught.
            for i in $(seq 600); do
                grep -qE '^SigCgt:.*[4567cdef][0-9a-f]{3}$' /proc/$raylex/status && break; sleep 0.05
            done
            sleep )" + std::to_string(after) +
                                          R"(
            ( sleep 60; kill -KILL $raylex ) >/dev/null 2>&1 & guard=$!
            begin=$EPOCHREALTIME; kill -)" +
                                          signal + R"( $raylex; wait $raylex; code=$?; end=$EPOCHREALTIME
            kill $guard
            echo $((${end/./} - ${begin/./})) >microseconds
            exit $code)"),
                    0};
    stopped.seconds = std::stod(folder.read("microseconds")) / 1e6;
    return stopped;
}

/// Under nohup, SIGHUP is ignored by children too, and the program keeps that: it would never end here.
class HangingUpIsHeard {
  public:
    HangingUpIsHeard() : before_(std::signal(SIGHUP, SIG_DFL)) {}
    ~HangingUpIsHeard() { std::signal(SIGHUP, before_); }
    HangingUpIsHeard(const HangingUpIsHeard&) = delete;
    HangingUpIsHeard& operator=(const HangingUpIsHeard&) = delete;

  private:
    void (*before_)(int);
};

/// The second that stopping may take, plus a margin for a busy machine.
constexpr double soon = 1 + 2;

}  // namespace

TEST_CASE("Every terminating signal stops a path without end", "[cli][stopping][gate]") {
    const Folder folder;
    const HangingUpIsHeard heard;
    folder.write("box.pbrt", endless_scene());
    for (const char* signal : {"INT", "TERM", "HUP"}) {
        INFO(signal);
        const Stopped stopped = stop_by(folder, "render box.pbrt --checkpoint 60s", signal, 0.7);
        INFO(stopped.outcome.err);
        CHECK(stopped.outcome.code == 130);
        CHECK(stopped.seconds < soon);
        CHECK(stopped.outcome.err.find("interrupted") != std::string::npos);
    }
}

TEST_CASE("The time limit stops a path without end", "[cli][stopping]") {
    const Folder folder;
    folder.write("box.pbrt", endless_scene());
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome = run_raylex(folder, "render box.pbrt --time 0.5s");
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < 0.5 + soon);
    CHECK(outcome.code == 1);
    CHECK(outcome.err.find("before any sample was finished") != std::string::npos);
    CHECK_FALSE(folder.has("box.exr"));
}

TEST_CASE("A signal stops loading", "[cli][stopping]") {
    const Folder folder;
    std::string scene = "WorldBegin\n";
    for (int i = 0; i < 400'000; ++i) scene += "Translate 0.01 0 0\nShape \"sphere\" \"float radius\" 0.01\n";
    folder.write("many.pbrt", scene);
    const Stopped stopped = stop_by(folder, "render many.pbrt", "TERM", 0.4);
    INFO(stopped.outcome.err);
    CHECK(stopped.outcome.code == 130);
    CHECK(stopped.seconds < soon);
    CHECK(stopped.outcome.err.find("interrupted before anything was rendered; no file was written") !=
          std::string::npos);
}

TEST_CASE("Values out of range are named and never end the program by a signal", "[cli][law7]") {
    const Folder folder;
    const std::string head = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n",
                      sky = "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n",
                      ball = "Shape \"sphere\" \"float radius\" 1\n";
    const auto camera = [](const std::string& z) {
        return "LookAt 0 0 " + z + "  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n";
    };
    const auto instance = [&](const std::string& transform) {
        return head + camera("-5") + sky + "ObjectBegin \"a\"\n" + ball + "ObjectEnd\n" + transform +
               "\nObjectInstance \"a\"\n";
    };
    std::string scales;
    for (int i = 0; i < 10; ++i) scales += "Scale 1e10 1e10 1e10\n";
    const struct {
        std::string scene, expected;
    } cases[] = {
        {instance("Scale 1e-18 1e-18 1e-18"),
         "scene.pbrt:10:1: the instance's transform cannot be inverted in single precision"},
        {instance("Scale 1e-10 1 1e10 Scale 1e-10 1 1e10"), "scene.pbrt:10:1: the instance reaches to 1e+20"},
        {instance("Scale 1e18 1e-18 1"), "the instance"},
        // Invertible only in double: in float the determinant is 0, or its first digit is a rounding error.
        {instance("ConcatTransform [1 1 0 0  1 1.00000001 0 0  0 0 1 0  0 0 0 1]"),
         "scene.pbrt:10:1: the instance's transform cannot be inverted in single precision"},
        {instance("ConcatTransform [1 1 1 0  1 1 1.0000001 0  1 1.0000001 1 0  0 0 0 1]"),
         "scene.pbrt:10:1: the instance's transform cannot be inverted in single precision"},
        {head + camera("1e19") + sky + ball, "scene.pbrt:3:1: the camera stands at"},
        {head + camera("4e18") + sky + "Shape \"sphere\" \"float radius\" 1e18\n",
         "scene.pbrt:6:1: the shape reaches to 1e+18 from the origin; expected at most 2.5e+17"},
        {head + camera("5") + sky + ball + "Shape \"sphere\" \"float radius\" 1e18\n",
         "scene.pbrt:7:1: the shape reaches to 1e+18 from the origin; expected at most 2.5e+17"},
        {head + camera("5") + sky + scales + ball,
         "the shape reaches to 1e+100 from the origin; expected at most 1e+18"},
        {head + camera("5") + sky + "LightSource \"point\" \"point3 from\" [1e30 0 0]\n" + ball,
         "scene.pbrt:6:1: the light stands at"},
    };
    for (const auto& [scene, expected] : cases) {
        folder.write("scene.pbrt", scene);
        const Outcome outcome = run_raylex(folder, "render scene.pbrt --spp 2");
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(expected) != std::string::npos);
    }
}

TEST_CASE("waiting for a pipe can be interrupted, with the right exit code", "[law7]") {
    const SceneFolder folder;
    for (const char* command : {"render room.pbrt --channels <(sleep 20) -o x.exr", "lpe check --channels <(sleep 20)",
                                "lpe vectors <(sleep 20)"}) {
        CAPTURE(command);
        const Outcome outcome =
            run_shell(folder, std::string("timeout --preserve-status -s INT 0.5 \"$RAYLEX\" ") + command);
        CAPTURE(outcome.err);
        CHECK(outcome.code == 130);
        CHECK_FALSE(folder.has("x.exr"));
    }
}
