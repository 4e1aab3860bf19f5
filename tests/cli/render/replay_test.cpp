// Law 6 on the command line: rejected samples are reported with the command that renders them again.
#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "experiments/job/text/json.h"
#include "support.h"

using namespace raylex::test;

namespace {

std::string broken_scene() {
    std::string text = small_scene();
    // So close to the floor that the radiance there exceeds float.
    const std::string light = "\"rgb I\" [3 3 3] \"point3 from\" [0 2 1]";
    return text.replace(text.find(light), light.size(), "\"rgb I\" [3e38 3e38 3e38] \"point3 from\" [0 .4 1]");
}

}  // namespace

TEST_CASE("rejected samples are reported with the command that replays them", "[law6]") {
    const Folder folder;
    folder.write("it's.pbrt", broken_scene());
    const Outcome outcome =
        run_raylex(folder, "render \"it's.pbrt\" -o a.exr --seed 7 --lpe lit=CDL --aov invalidSamples --stats s.json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.find("The first: pixel (") != std::string::npos);
    CHECK(outcome.err.find("seed 7") != std::string::npos);
    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    const auto& invalid = json["invalid_samples"];
    CHECK(invalid["count"].get<int>() > 0);
    CHECK(invalid["by_channel"]["beauty"] == invalid["count"]);
    auto image = raylex::display::read_exr(folder.path("a.exr"));
    REQUIRE(image);
    double counted = 0;
    for (const float v : image->layer("invalidSamples")->planes.front().values) counted += static_cast<double>(v);
    CHECK(counted == invalid["count"].get<double>());

    REQUIRE(!invalid["logged"].empty());
    const auto& first = invalid["logged"][0];
    CHECK(first["replay"]["seed"] == 7);
    const std::string command = first["replay"]["command"];
    const std::string sample =
        "--replay " + first["pixel"][0].dump() + "," + first["pixel"][1].dump() + "," + first["sample"].dump();
    CHECK(command.find(sample) != std::string::npos);
    CHECK(outcome.err.find(command) != std::string::npos);
    const std::vector<std::string> before = folder.names();
    const Outcome again = run_shell(folder, command);
    CAPTURE(command, again.out, again.err);
    CHECK(again.code == 1);
    CHECK(again.out.find("refused: (") != std::string::npos);
    CHECK(again.out.find("beauty: (") != std::string::npos);
    CHECK(folder.names() == before);  // nothing is written

    CHECK(run_raylex(folder, "render \"it's.pbrt\" --replay 0,0,0").code == 0);
    for (const char* wrong : {"16,0,0", "0,0,4", "0,0", "a,0,0", "0,0,0,0", "0,0,-1"}) {
        const Outcome refused = run_raylex(folder, std::string("render \"it's.pbrt\" --replay ") + wrong);
        CAPTURE(wrong, refused.err);
        CHECK(refused.code == 2);
        CHECK(refused.err.find("expected") != std::string::npos);
    }
}
