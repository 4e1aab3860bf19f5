// raylex render --cryptomatte and --aov: options, contents of the file, and refused requests.
#include <bit>

#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "experiments/job/text/json.h"
#include "geoaovs/cryptomatte.h"
#include "geoaovs/geoaovs.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;
using raylex::geoaovs::matte_id;

TEST_CASE("cryptomattes are written with their manifests, and the report shows them") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    Outcome outcome =
        run_raylex(folder, "render room.pbrt --cryptomatte object,material --cryptomatte-ranks 4 --stats s.json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("room.exr"));
    REQUIRE(image);
    for (const char* layer : {"CryptoObject00", "CryptoObject01", "CryptoMaterial00", "CryptoMaterial01"}) {
        CAPTURE(layer);
        REQUIRE(image->layer(layer) != nullptr);
        CHECK(image->layer(layer)->planes.size() == 4);
    }
    CHECK(image->layer("CryptoObject02") == nullptr);
    CHECK(image->layer("CryptoAsset00") == nullptr);
    CHECK(image->attributes["cryptomatte/3ae39a5/name"] == "CryptoObject");
    CHECK(image->attributes["cryptomatte/be359d6/hash"] == "MurmurHash3_32");
    CHECK(image->attributes["cryptomatte/be359d6/conversion"] == "uint32_to_float32");
    const auto manifest = raylex::experiments::parse_json(image->attributes["cryptomatte/be359d6/manifest"]);
    REQUIRE(manifest.size() == 1);
    CHECK(std::stoul(manifest["ground"].get<std::string>(), nullptr, 16) == matte_id("ground"));
    const auto* ids = image->layer("CryptoMaterial00")->plane("R");
    const auto* coverage = image->layer("CryptoMaterial00")->plane("G");
    const auto* alpha = image->layer("beauty")->plane("A");
    for (std::size_t i = 0; i < 256; ++i) {
        CHECK(coverage->values[i] == Approx(alpha->values[i]).margin(1e-4));
        if (coverage->values[i] > 0) CHECK(std::bit_cast<std::uint32_t>(ids->values[i]) == matte_id("ground"));
    }
    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    REQUIRE(json["cryptomatte"].size() == 2);
    CHECK(json["cryptomatte"][0]["names"] == 2);
    CHECK(json["cryptomatte"][0]["remainder"]["pixels"] == 0);
    CHECK(run_raylex(folder, "report room.exr -o page.html").code == 0);
    CHECK(folder.read("page.html").find("as bright as it covers the pixel") != std::string::npos);
}

TEST_CASE("a job can request cryptomattes and every AOV by name") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    std::string aovs;
    for (const std::string& name : raylex::geoaovs::channel_names()) aovs += "\"" + name + "\", ";
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[channels]\ncryptomatte = [\"asset\"]\naovs = [" + aovs + "]\n");
    Outcome outcome = run_raylex(folder, "render job.toml");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("job.exr"));
    REQUIRE(image);
    CHECK(image->layer("CryptoAsset02") != nullptr);
    for (const std::string& name : raylex::geoaovs::channel_names()) {
        CAPTURE(name);
        CHECK(image->layer(name) != nullptr);
        CHECK_FALSE(image->attributes["rule/" + name].empty());
    }
    CHECK(image->attributes["rule/sampleCount"] == "sum");
    CHECK(image->attributes["lpe/Ci"] == "C.*");
    CHECK(image->layer("sampleCount")->planes[0].values[0] == 4);
    CHECK(image->layer("Ci")->plane("R")->values == image->layer("beauty")->plane("R")->values);
    CHECK(image->layer("a")->planes[0].values == image->layer("beauty")->plane("A")->values);
}

TEST_CASE("invalid cryptomattes and AOVs are refused with the reason") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const auto refused = [&](const std::string& arguments, const std::string& words) {
        CAPTURE(arguments);
        Outcome outcome = run_raylex(folder, "render room.pbrt " + arguments);
        CAPTURE(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(words) != std::string::npos);
        CHECK(folder.names() == std::vector<std::string>{"room.pbrt"});
    };
    refused("--cryptomatte objects", "did you mean 'object'?");
    refused("--cryptomatte object,object", "requested twice");
    refused("--cryptomatte object --cryptomatte-ranks 5", "even");
    refused("--cryptomatte object --filter mitchell", "has negative lobes");
    refused("--cryptomatte object --lpe CryptoObject00=CDL", "cryptomatte");
    refused("--aov motionFore", "does not compute yet");
    refused("--aov incidence_angle", "did you mean 'incidenceAngle'?");
    const std::string job =
        folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[channels]\ncryptomatte = [\"objekt\"]\n");
    Outcome outcome = run_raylex(folder, "render job.toml");
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("job.toml:4:17") != std::string::npos);
}
