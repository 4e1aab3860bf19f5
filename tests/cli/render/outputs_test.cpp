// Outputs of a render: storage, drivers, viewers, deep images, memory.
#include <catch2/catch.hpp>

#include <algorithm>

#include "display/output/reader/exr_reader.h"
#include "display/output/writer/deep_file.h"
#include "experiments/job/text/json.h"
#include "support.h"
#include "tests/display/tev_receiver.h"

using namespace raylex::test;
using raylex::display::read_exr;

namespace {

std::size_t occurrences(const std::string& text, const std::string& word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

}  // namespace

TEST_CASE("flags and jobs choose the storage, and headers contain the results of checks") {
    const SceneFolder folder;
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[channels]\nshipped_partition = true\naovs = [\"Nn\"]\n"
                 "[exr]\nlight = \"piz\"\nnormal = \"half zips\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o a.exr --exr normal='float rle'").code == 0);
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    CHECK(image->attributes["storage/Nn"] == "float rle");
    CHECK(image->attributes["storage/beauty"] == "float piz");
    CHECK(image->attributes["colorInteropID"] == "lin_rec709_scene");
    CHECK(image->attributes["verdict/shipped"].starts_with("holds; "));
    CHECK(run_raylex(folder, "verify a.exr").code == 0);

    check_refused(folder, "render room.pbrt -o b.exr --exr light=pxr24", {"--exr", "loses bits"});
    check_refused(folder, "render room.pbrt -o b.exr --exr single --exr light=dwaa",
                  {"a single part has one compression"});
    check_refused(folder, "render room.pbrt -o b.exr --exr depth=zip", {"unknown kind", "light"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\nid = \"half\"\n");
    check_refused(folder, "render bad.toml -o b.exr", {"bad.toml:4", "expected uint"});
}

TEST_CASE("the memory of layers is printed before rendering, and a limit refuses by name") {
    const SceneFolder folder;
    const Outcome outcome =
        run_raylex(folder, "render room.pbrt --lpe direct=CDL --aov z --stats s.json --memory-limit 1G");
    CAPTURE(outcome.out);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("\nmemory: ") < outcome.out.find("\nroom.exr: "));
    CHECK(outcome.out.find(" for 4 layers, of at most 1.0 GiB") != std::string::npos);
    CHECK(outcome.out.find("12.0 KiB each: direct, rest") != std::string::npos);  // 16 x 16 x 48 bytes
    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    CHECK(json["memory"]["layers"]["direct"] == 16 * 16 * 48);
    CHECK(json["memory"]["limit_bytes"] == 1 << 30);
    std::uint64_t sum = 0;
    for (const auto& each : json["memory"]["layers"]) sum += each.get<std::uint64_t>();
    CHECK(json["memory"]["total_bytes"] == sum);

    check_refused(folder, "render room.pbrt -o b.exr --lpe direct=CDL --memory-limit 40k",
                  {"more than the limit of 40.0 KiB", "The largest: beauty 36.0 KiB"});
    check_refused(folder, "render room.pbrt -o b.exr --memory-limit lots", {"--memory-limit", "such as 8G"});
}

TEST_CASE("any layer can be a preview, through any view") {
    const SceneFolder folder;
    const Outcome outcome = run_raylex(
        folder,
        "render room.pbrt --aov Nn --lpe direct=CDL --preview b.png --preview Nn=n.png --preview direct=d.png "
        "--view Raw --driver png:file=e.png,layer=direct,exposure=2,size=8");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(folder.names() == std::vector<std::string>{"b.png", "d.png", "e.png", "n.png", "room.exr", "room.pbrt"});
    for (const char* file : {"b.png", "d.png", "e.png", "n.png"}) {
        CHECK(folder.read(file).substr(1, 3) == "PNG");
        CHECK(outcome.out.find(file) != std::string::npos);
    }
    CHECK(folder.read("b.png") != folder.read("d.png"));
    check_refused(folder, "render room.pbrt -o x.exr --aov Nn --preview Nm=n2.png",
                  {"unknown layer 'Nm'", "did you mean 'Nn'"});
    check_refused(folder, "render room.pbrt -o x.exr --preview a.png --view Rwa", {"view 'Rwa'", "did you mean 'Raw'"});
    check_refused(folder, "render room.pbrt -o x.exr --preview a.png --driver png:file=a.png",
                  {"'a.png' is already an input or another output"});
    check_refused(folder, "render room.pbrt -o x.exr --preview Nn=absent/p.png --aov Nn", {"absent/p.png"});
    check_refused(folder, "render room.pbrt -o x.exr --driver gif:file=a.gif",
                  {"unknown display driver 'gif'", "exr, tev, png"});
}

TEST_CASE("a deep image flattens to the image, for any number of threads", "[law3]") {
    const SceneFolder folder;
    std::vector<std::string> data;
    for (const char* threads : {"1", "3"}) {
        const Outcome outcome = run_raylex(folder, std::string("render room.pbrt --lpe direct=CDL --deep deep.exr "
                                                               "--deep-channels direct --deep-samples 2 --threads ") +
                                                       threads);
        CAPTURE(outcome.out, outcome.err);
        REQUIRE(outcome.code == 0);
        CHECK(outcome.out.find("deep: 2 layers flattened equal the image") != std::string::npos);
        const std::string bytes = folder.read("deep.exr");
        data.push_back(bytes.substr(bytes.size() / 2));  // pixels; the header contains the time
        auto image = read_exr(folder.path("room.exr"));
        REQUIRE(image);
        const auto result = raylex::display::check_deep(folder.path("deep.exr"), *image);
        REQUIRE(result.ok());
        CHECK(result->holds);
        CHECK(result->most_samples <= 3);
        // An empty pixel has no sample; any other has at least one.
        const auto* alpha = image->layer("")->plane("A");
        REQUIRE(alpha != nullptr);
        const auto covered = std::count_if(alpha->values.begin(), alpha->values.end(), [](float a) { return a > 0; });
        CHECK(covered > 100);
        CHECK(result->samples >= static_cast<std::uint64_t>(covered));
    }
    CHECK(data[0] == data[1]);
    check_refused(folder, "render room.pbrt -o x.exr --deep d.exr --filter mitchell",
                  {"negative lobes", "expected box"});
    check_refused(folder, "render room.pbrt -o x.exr --deep d.exr --deep-channels Nm --aov Nn",
                  {"'Nm'", "did you mean 'Nn'"});
    check_refused(folder, "render room.pbrt -o x.exr --deep d.exr --deep-channels id --aov id",
                  {"'id' cannot be deep"});
    check_refused(folder, "render room.pbrt -o x.exr --deep d.exr --deep-storage zip", {"--deep-storage", "zips"});
    check_refused(folder, "render room.pbrt -o x.exr --deep-tidy", {"--deep FILE.exr"});
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[deep]\nfile = \"j.exr\"\ntidy = true\nsamples = 8\n"
                 "tolerance = 0.01\nstorage = \"half rle\"\n");
    CHECK(run_raylex(folder, "render job.toml").code == 0);
    CHECK(!folder.read("j.exr").empty());
}

TEST_CASE("a render can be watched in a viewer, and continues without one", "[tev]") {
    const SceneFolder folder;
    {
        TevReceiver viewer;
        const Outcome outcome = run_raylex(
            folder, "render room.pbrt --lpe direct=CDL --aov z --tev 127.0.0.1:" + std::to_string(viewer.port()));
        CAPTURE(outcome.err);
        REQUIRE(outcome.code == 0);
        auto image = read_exr(folder.path("room.exr"));
        REQUIRE(image);
        const auto& red = image->layer("direct")->plane("R")->values;
        std::vector<float> seen;
        for (int i = 0; i < 300 && seen != red; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            seen = viewer.images()["room.exr"].channels["direct.R"];
        }
        CHECK(seen == red);
        CHECK(viewer.images()["room.exr"].channels["Z"] == image->layer("z")->plane("Z")->values);
        CHECK(viewer.images()["room.exr"].order == std::vector<std::string>{"R", "G", "B", "A", "direct.R", "direct.G",
                                                                            "direct.B", "rest.R", "rest.G", "rest.B",
                                                                            "Z"});
        CHECK(viewer.complaint().empty());
    }
    int port;
    {
        const TevReceiver gone;
        port = gone.port();
    }
    const Outcome outcome = run_raylex(folder, "render room.pbrt --tev 127.0.0.1:" + std::to_string(port));
    CHECK(outcome.code == 0);
    CHECK(occurrences(outcome.err, "the viewer at 127.0.0.1:" + std::to_string(port)) == 1);
    check_refused(folder, "render room.pbrt -o x.exr --tev 127.0.0.1:0", {"--tev", "expected HOST:PORT"});
}
