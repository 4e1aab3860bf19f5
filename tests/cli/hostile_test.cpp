// Attempts to break the program: names that could become commands, system limits, numbers beyond their type, truncated
// files.
#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <thread>

#include "../display/files.h"
#include "display/output/writer/exr_edit.h"
#include "experiments/program/work_lock.h"
#include "support.h"
#include "tests/support/paths.h"
#include "tests/support/skip.h"

namespace raylex::test {
namespace {

/// Half of the image shows a sky, half a surface below it.
std::string under_a_sky(const std::string& sky, const std::string& reflectance, const std::string& more = {}) {
    return "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\nCamera \"perspective\" \"float fov\" "
           "60\n" +
           more + "WorldBegin\nLightSource \"infinite\" \"rgb L\" [" + sky +
           "]\nTranslate 0 0 3\nMaterial \"diffuse\" \"rgb reflectance\" [" + reflectance + "]\nShape \"sphere\"\n";
}

}  // namespace

TEST_CASE("a name with a line end never becomes a line of a job file", "[cli][law7][gate]") {
    const Folder folder;
    const std::string name = "x\ntouch PWNED\n#", scene = folder.write(name + ".pbrt", small_scene());
    folder.write("room.pbrt", small_scene());
    const std::string common = " --spp 64 --shards 2 --no-calibration ";
    for (const std::string format : {"shell", "make", "snakemake", "opencue", "kubernetes"}) {
        CAPTURE(format);
        for (const std::string& what :
             {"'" + scene + "' -o out.exr", "room.pbrt -o '" + name + ".exr'", std::string("room.pbrt -o $'a\\rb.exr'"),
              std::string("room.pbrt -o $'a\\xe2\\x80\\xa8b.exr'")}) {
            CAPTURE(what);
            const Outcome refused = run_shell(folder, "\"$RAYLEX\" render " + what + common + "--commands=" + format);
            CHECK(refused.code == 2);
            CHECK(refused.out.empty());
            CHECK(contains(refused.err, "has a control character"));
        }
    }
    CHECK(contains(run_shell(folder, "\"$RAYLEX\" render '" + scene + "' -o out.exr" + common + "--commands=json").out,
                   "x\\ntouch"));
    // Bytes that are not UTF-8 would be replaced, or would end the reading of the file.
    const std::string latin = "\"$RAYLEX\" render room.pbrt -o $'caf\\xe9.exr'" + common;
    for (const std::string format : {"json", "snakemake", "opencue", "kubernetes"})
        CHECK(contains(run_shell(folder, latin + "--commands=" + format).err, "is not UTF-8"));
    CHECK(run_shell(folder, latin + "--commands=make").code == 0);
    const Outcome cue =
        run_shell(folder, "\"$RAYLEX\" render room.pbrt -o 'a--b<&\">.exr'" + common + "--commands=opencue");
    REQUIRE(cue.code == 0);
    CHECK_FALSE(contains(cue.out.substr(0, cue.out.find("-->")), "a--b"));

    folder.write(
        "c.toml",
        "[[scene]]\nname = \"room\"\nfile = \"room.pbrt\"\n[[method]]\nname = \"path\"\n[budget]\nsamples = [1]\n");
    const std::string submit = "\"$RAYLEX\" submit --slurm c.toml --no-calibration --shards 1 -o ";
    for (const std::string what : {"$'d\\n#SBATCH --wrap=id'", "dir --option=$'--x\\n#SBATCH --wrap=id'"})
        CHECK(contains(run_shell(folder, submit + what).err, "has a control character"));
    static_cast<void>(run_shell(folder, submit + "'d\" --wrap=\"id'"));
    CHECK(contains(run_shell(folder, "cat d*/slurm/merge.sh").out, "d\\\" --wrap=\\\"id/slurm/merge.log\""));
}

TEST_CASE("if the system starts fewer threads, the image is the same", "[cli][law3]") {
#ifdef __SANITIZE_ADDRESS__
    RAYLEX_SKIP("the sanitizer takes more address space than the limit");
#endif
    const SceneFolder folder;
    CHECK(run_raylex(folder, "render room.pbrt -o whole.exr --spp 64 --threads 2").code == 0);
    // The stacks of a thousand threads do not fit; the memory of their workers does.
    const Outcome limited =
        run_shell(folder, "ulimit -v 8000000; exec \"$RAYLEX\" render room.pbrt -o out.exr --spp 64 --threads 1500");
    INFO(limited.err);
    CHECK(limited.code == 0);
    CHECK(count_matches(
              limited.err,
              "[0-9]+ of 1500 threads rendered the image, with the same bits: the system cannot start more") == 1);
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
}

TEST_CASE("values that a file cannot hold are counted, and splits are checked on all other values", "[cli][law6]") {
    const Folder folder;
    folder.write("bright.pbrt", under_a_sky("1e6 1e6 1e6", ".5 .5 .5"));
    const Outcome half =
        run_raylex(folder, "render bright.pbrt --spp 16 --exr 'all=half none' --lpe 'd=C<RD>L' -o h.exr");
    INFO(half.out << half.err);
    CHECK(half.code == 1);  // every pixel of the file is clamped
    CHECK(contains(
        half.err,
        "the file cannot hold all values of 3 layers: beauty: 0 values not a number, set to 0; 768 beyond half"));
    CHECK(contains(half.out, "CANNOT TELL: every pixel is clamped; 256 pixels with values clamped"));
    CHECK(contains(half.out, "0 of 256 pixels judged"));
    const Outcome verified = run_raylex(folder, "verify h.exr");
    CHECK(verified.code == 1);
    CHECK(contains(verified.err, "the file cannot hold all values of 3 layers"));
    CHECK(contains(verified.out, "CANNOT TELL: every pixel is clamped"));
    CHECK(contains(verified.out, "0 of 256 pixels judged"));
    REQUIRE(run_raylex(folder, "report h.exr -o h.html").code == 0);
    const std::string page = folder.read("h.html");
    CHECK_FALSE(contains(page, "Every split holds"));
    CHECK(contains(page, "Cannot tell for 1 of 1 partitions"));
    CHECK(contains(page, "0 of 256</td>"));
    // The beauty exceeds float, but none of its layers does.
    folder.write("float.pbrt",
                 under_a_sky("2e38 2e38 2e38", "1 1 1", "") + "LightSource \"infinite\" \"rgb L\" [3e38 3e38 3e38]\n");
    const Outcome single = run_raylex(folder, "render float.pbrt --spp 16 --lpe 'd=C<RD>L' -o f.exr");
    INFO(single.out << single.err);
    CHECK(single.code == 1);  // every pixel of the file is clamped
    CHECK(contains(single.out, "CANNOT TELL: every pixel is clamped"));
    CHECK(contains(single.err, "beyond float, set to the largest"));
    // Deep images and atlases follow the same rule.
    const Outcome deep = run_raylex(folder, "render bright.pbrt --spp 16 -o b.exr --deep deep.exr --deep-storage half");
    INFO(deep.out << deep.err);
    CHECK(deep.code == 0);
    CHECK(contains(deep.err, "deep.exr: the file cannot hold all values of 1 layer: beauty: 0 values not a number"));
    CHECK(contains(deep.err, "--deep-storage float stores larger values"));
    CHECK(contains(deep.out, "256 pixels with values clamped to the largest half or float"));
    const Outcome beyond =
        run_raylex(folder, "render float.pbrt --spp 16 -o f.exr --deep deep.exr --atlas f.atlas.exr");
    INFO(beyond.out << beyond.err);
    CHECK(beyond.code == 0);
    CHECK(contains(beyond.err, "deep.exr: the file cannot hold all values of 1 layer"));
    const Outcome atlas = run_raylex(folder, "verify f.atlas.exr");
    CHECK(atlas.code == 0);
    CHECK(contains(atlas.out, "256 pixels with values clamped to the largest half or float"));
}

TEST_CASE("samples that cancel with a negative-lobe filter do not fail a split", "[cli][law1][gate]") {
    const Folder folder;
    std::string scene =
        "Film \"rgb\" \"integer xresolution\" 256 \"integer yresolution\" 256\nCamera \"perspective\" "
        "\"float fov\" 60\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
        "Material \"diffuse\" \"rgb reflectance\" [1e-9 1e-9 1e-9]\n";
    // Many edges, so that some pixel has equal numbers of sky samples of each sign.
    for (int i = 0; i < 400; ++i)
        scene += "AttributeBegin Translate " + std::to_string(0.19 * (i % 20) - 1.9) + " " +
                 std::to_string(0.19 * (i / 20) - 1.9) + " 4 Shape \"sphere\" \"float radius\" " +
                 std::to_string(0.01 + 0.0002 * i) + " AttributeEnd\n";
    folder.write("dark.pbrt", scene);
    for (const std::string filter : {"sinc"})
        for (const std::string spp : {"9", "16", "25"}) {
            CAPTURE(filter, spp);
            const Outcome outcome =
                run_raylex(folder, "render dark.pbrt -o out.exr --lpe 'd=C<RD>L' --lpe bg=CB --filter " + filter +
                                       " --spp " + spp);
            INFO(outcome.out);
            CHECK(outcome.code == 0);
            const Outcome verified = run_raylex(folder, "verify out.exr");
            CHECK(verified.code == 0);
            CHECK(contains(verified.out, "samples that cancel, 2^-45 each"));
        }
    CHECK(run_raylex(folder, "render dark.pbrt -o out.exr --lpe 'd=C<RD>L' --filter gaussian --spp 4").code == 0);
    CHECK_FALSE(contains(run_raylex(folder, "verify out.exr").out, "samples that cancel"));
}

TEST_CASE("a truncated atlas is refused for every kind of request", "[cli][law7]") {
    const SceneFolder folder;
    CHECK(run_raylex(folder, "render room.pbrt --spp 16 --atlas a.atlas.exr -o out.exr").code == 0);
    const std::string bytes = folder.read("a.atlas.exr");
    CHECK(run_raylex(folder, "ask a.atlas.exr --lpe 'd=C<RD>L' -o d.exr").code == 0);
    for (const std::size_t less : {std::size_t{1}, std::size_t{100}, bytes.size() / 10}) {
        CAPTURE(less);
        folder.write("a.atlas.exr", bytes.substr(0, bytes.size() - less));
        const Outcome cut = run_raylex(folder, "ask a.atlas.exr --lpe 'd=C<RD>L' -o d.exr");
        CHECK(cut.code == 2);
        CHECK(contains(cut.err, "truncated or damaged"));
    }
    std::string negative = bytes;
    const std::size_t at = negative.find("atlas/length");
    REQUIRE(at != std::string::npos);
    const std::size_t value = negative.find("string", at) + 7 + 4;  // the zero byte after the type, and the size
    const auto digits = static_cast<std::size_t>(static_cast<unsigned char>(negative[value - 4]));
    negative.replace(value, digits, "-" + std::string(digits - 1, '1'));
    folder.write("a.atlas.exr", digits > 1 ? negative : bytes.substr(0, value) + "x" + bytes.substr(value + 1));
    CHECK(contains(run_raylex(folder, "ask a.atlas.exr --lpe 'd=C<RD>L' -o d.exr").err,
                   "in atlas/length is not a length"));
}

TEST_CASE("scenes and requests that need too much memory are refused quickly", "[cli][law7][gate]") {
    const SceneFolder folder;
    std::string scene =
        "WorldBegin\nLightSource \"infinite\"\nObjectBegin \"a\"\nShape \"sphere\"\nObjectEnd\nActiveTransform "
        "EndTime\n"
        "Rotate 90 0 0 1\nActiveTransform All\n";
    for (int i = 0; i < 100000; ++i) scene += "ObjectInstance \"a\"\n";
    folder.write("many.pbrt", "Camera \"perspective\"\n" + scene);
    check_refused(folder, "render many.pbrt --spp 1 -o out.exr",
                  {"many.pbrt:1010", "more than 1000 instances of one object stand at the same place"});
    check_refused(folder, "render room.pbrt --spp 16000000 --shards 1000000 --commands --no-calibration -o out.exr",
                  {"--shards", "100000"});
    std::string many;
    for (int i = 0; i < 5000; ++i) many += " --lpe a" + std::to_string(i) + "=CDL";
    CHECK(run_raylex(folder, "render room.pbrt --spp 1 --atlas a.atlas.exr -o out.exr").code == 0);
    check_refused(folder, "ask a.atlas.exr -o d.exr" + many, {"expected at most 4096"});
}

TEST_CASE("an interrupt is the exit code 130, and a second one leaves no partial file", "[cli][law7][gate]") {
    const SceneFolder folder;
    const std::string interrupted = "timeout --preserve-status -s INT 1 \"$RAYLEX\" ";
    CHECK(run_shell(folder, interrupted + "render room.pbrt --spp 64000 --shards 2 --commands -o out.exr").code == 130);
    CHECK(run_shell(folder, interrupted + "scene check --invariants --mean-samples 10000000 room.pbrt").code == 130);
    // Large enough that writing takes at least a second.
    const Outcome twice = run_shell(
        folder,
        "\"$RAYLEX\" render room.pbrt --resolution 1000x800 --spp 4000 --partition shipped -o big.exr & pid=$!\n"
        "sleep 2; kill -INT $pid\n"
        "for i in $(seq 400); do ls *.partial >/dev/null 2>&1 && break; sleep 0.05; done\n"
        "ls *.partial; kill -INT $pid; wait $pid; echo code $?");
    INFO(twice.out << twice.err);
    CHECK(contains(twice.out, "big.exr."));
    CHECK(contains(twice.out, "code 130"));
    for (const std::string& name : folder.names()) CHECK_FALSE(contains(name, "partial"));
    // After an interrupt the program must not read the file again.
    // A busy machine with sanitizers needs longer until the first sample of every pixel, before which nothing is
    // written.
    const Outcome once = run_shell(folder,
                                   "for seconds in 3 10 30; do\n"
                                   "  timeout --preserve-status -s INT $seconds \"$RAYLEX\" "
                                   "render room.pbrt --spp 6400000 --partition shipped -o once.exr; code=$?\n"
                                   "  [ ! -e once.exr ] || break\n"
                                   "done; exit $code");
    INFO(once.out << once.err);
    CHECK(once.code == 130);
    CHECK(contains(once.out, "partition 'shipped', checked while it was written: holds; "));
    CHECK_FALSE(contains(once.out, "sum to beauty"));
    CHECK(run_raylex(folder, "verify once.exr").code == 0);
}

TEST_CASE("a lock has one holder, although each holder removes its file", "[cli]") {
    const Folder folder;
    const std::string file = folder.path("work.lock");
    std::atomic<int> holders{0}, most{0};
    std::vector<std::thread> threads;
    // The lock distinguishes open files, not threads, so threads behave like processes here. If take() did not check
    // that the file still exists, a second holder would appear within 0.03 s (26 runs of 26, on one processor and on
    // two).
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end = Clock::now() + std::chrono::seconds(1);
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
            while (Clock::now() < end && most < 2) {
                const auto lock = experiments::WorkLock::take(file, "works");
                if (!lock) continue;
                const int now = ++holders;
                if (now > most) most = now;
                std::this_thread::sleep_for(std::chrono::microseconds(20));
                --holders;
            }
        });
    for (std::thread& each : threads) each.join();
    CHECK(most == 1);
}

TEST_CASE("a test of a lock does not take it", "[cli]") {
    const Folder folder;
    const std::string file = folder.path("work.lock");
    std::atomic<bool> over{false};
    std::thread looks([&] {
        while (!over) static_cast<void>(experiments::WorkLock::is_held(file));
    });
    int refused = 0;
    for (int i = 0; i < 4000; ++i) refused += experiments::WorkLock::take(file, "works") ? 0 : 1;
    over = true;
    looks.join();
    CHECK(refused == 0);
    const auto held = experiments::WorkLock::take(file, "works");
    REQUIRE(held);
    CHECK(experiments::WorkLock::is_held(file));
    CHECK_FALSE(experiments::WorkLock::take(file, "works"));
}

TEST_CASE("names of layers cannot control the terminal, and names of partitions lead to no other folder",
          "[cli][law7]") {
    const Folder folder;
    write_foreign(folder.path("odd.exr"), {{"R", Imf::FLOAT, {1}}, {"a\x1b[2J.Y", Imf::FLOAT, {-1}}}, 1, 1);
    for (const std::string color : {"never", "always"}) {
        const Outcome outcome = run_raylex(folder, "verify odd.exr --of beauty --sum 'a*' --color " + color);
        CHECK(contains(outcome.out + outcome.err, "a?[2J"));
        CHECK_FALSE(contains(outcome.out + outcome.err, "\x1b[2J"));
    }
    write_foreign(folder.path("plain.exr"), {{"R", Imf::FLOAT, {1}}, {"a.Y", Imf::FLOAT, {2}}}, 1, 1);
    display::ExrEdit edit;
    edit.attributes["partition/x/../../y"] = "beauty = a";
    REQUIRE(display::edit_exr(folder.path("plain.exr"), folder.path("split.exr"), edit));
    CHECK(run_raylex(folder, "verify split.exr").code == 1);
    CHECK(folder.has("split.x_.._.._y.residual.png"));
}

}  // namespace raylex::test
