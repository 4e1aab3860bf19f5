// Storage of an image: one part or many, with or without loss, all of it or a crop window.
#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

#include "display/output/reader/exr_reader.h"
#include "support.h"

using namespace raylex::test;
namespace display = raylex::display;
using display::read_exr;

TEST_CASE("a single part has the channels of all parts, and its splits are checked") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\nparts = \"single\"\n");
    const std::string layers = " --aov z --aov Nn --aov id --lpe direct=CDL --cryptomatte object";
    REQUIRE(run_raylex(folder, "render room.pbrt -o many.exr" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render room.pbrt -o one.exr --exr single --exr normal=half" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr" + layers).code == 0);
    CHECK(Imf::MultiPartInputFile(folder.path("one.exr").c_str()).parts() == 1);
    CHECK(Imf::MultiPartInputFile(folder.path("job.exr").c_str()).parts() == 1);
    auto many = read_exr(folder.path("many.exr")), one = read_exr(folder.path("one.exr"));
    REQUIRE((many && one));
    CHECK(one->attributes["lpe/direct"] == "CDL");
    CHECK(one->attributes["verdict/auto"].starts_with("holds; "));
    CHECK(one->layer("id")->planes.front().stored == display::StoredType::unsigned_int);
    CHECK(one->layer("Nn")->planes.front().stored == display::StoredType::half_float);
    for (const auto& [name, same] : {std::pair<const char*, const char*>{"", ""},
                                     {"direct", "direct"},
                                     {"z", "Z"},
                                     {"id", "id"},
                                     {"CryptoObject00", "CryptoObject00"}}) {
        CAPTURE(name);
        const display::ImageLayer *a = many->layer(name), *b = one->layer(same);
        REQUIRE((a != nullptr && b != nullptr));
        REQUIRE(a->planes.size() == b->planes.size());
        for (std::size_t p = 0; p < a->planes.size(); ++p)
            CHECK(std::equal(
                a->planes[p].values.begin(), a->planes[p].values.end(), b->planes[p].values.begin(),
                [](float x, float y) { return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y); }));
    }
    CHECK(run_raylex(folder, "verify one.exr").code == 0);
    check_refused(folder, "render room.pbrt -o x.exr --exr singel", {"did you mean 'single'?"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\nparts = \"two\"\n");
    check_refused(folder, "render bad.toml -o x.exr", {"bad.toml:4", "expected single, multi"});
}

TEST_CASE("a crop has the bits of the whole image in its window, with all outputs of a render", "[law3][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const std::string layers = " --lpe direct=CDL --aov z --aov Nn --cryptomatte object --statistics beauty=variance";
    REQUIRE(run_raylex(folder, "render room.pbrt -o whole.exr" + layers).code == 0);
    const Outcome outcome = run_raylex(
        folder,
        "render room.pbrt -o part.exr --crop 3,5,14,13 --preview part.png --deep deep.exr --threads 3" + layers);
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("flattened equal the image") != std::string::npos);
    const Imf::MultiPartInputFile file(folder.path("part.exr").c_str());
    for (int part = 0; part < file.parts(); ++part) {
        CHECK(file.header(part).dataWindow() == Imath::Box2i({3, 5}, {13, 12}));
        CHECK(file.header(part).displayWindow() == Imath::Box2i({0, 0}, {15, 15}));
    }
    auto whole = read_exr(folder.path("whole.exr")), part = read_exr(folder.path("part.exr"));
    REQUIRE((whole && part));
    REQUIRE(whole->layers.size() == part->layers.size());
    for (std::size_t l = 0; l < whole->layers.size(); ++l)
        for (std::size_t p = 0; p < whole->layers[l].planes.size(); ++p)
            for (std::size_t y = 0; y < 16; ++y)
                for (std::size_t x = 0; x < 16; ++x) {
                    const bool inside = x >= 3 && x < 14 && y >= 5 && y < 13;
                    const float a = whole->layers[l].planes[p].values[16 * y + x],
                                b = part->layers[l].planes[p].values[16 * y + x];
                    if ((inside ? std::bit_cast<std::uint32_t>(a) : 0U) != std::bit_cast<std::uint32_t>(b)) {
                        FAIL_CHECK(whole->layers[l].name << " at " << x << ", " << y << ": " << a << " and " << b);
                    }
                }
    CHECK(run_raylex(folder, "verify part.exr").code == 0);
    CHECK(run_raylex(folder, "compare part.exr part.exr --metric all").code == 0);
    // A job can do the same, and a checkpoint belongs to its crop.
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\ncrop = [3, 5, 14, 13]\n");
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr --checkpoint 1h" + layers).code == 0);
    auto job = read_exr(folder.path("job.exr"));
    REQUIRE(job);
    CHECK(job->layer("")->planes[0].values == part->layer("")->planes[0].values);
    CHECK(run_raylex(folder, "render room.pbrt --exr single -o single.exr --crop 0,0,1,1").code == 0);

    check_refused(folder, "render room.pbrt -o x.exr --crop 0,0,17,4", {"crop 0,0,17,4", "16 x 16"});
    check_refused(folder, "render room.pbrt -o x.exr --crop 4,0,4,4", {"--crop", "X0 < X1"});
    check_refused(folder, "render room.pbrt -o x.exr --crop 1,2,3", {"--crop", "X0,Y0,X1,Y1"});
    check_refused(folder, "render room.pbrt -o x.exr --crop 0,0,4,4 --until-error 5%", {"depend on the whole image"});
    check_refused(folder, "render room.pbrt -o x.exr --crop 0,0,4,4 --filter-mode splat", {"filter mode splat"});
    check_refused(folder, "render room.pbrt -o x.exr --crop 0,0,4,4 --integrator lighttracer", {"land anywhere"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\ncrop = [3, 5]\n");
    check_refused(folder, "render bad.toml -o x.exr", {"bad.toml:4", "expected [x0, y0, x1, y1]"});
}

TEST_CASE("presets store light as programs read it best, and splits hold to the rounding of half", "[law1]") {
    const SceneFolder folder;
    const std::string layers =
        " --lpe direct='C<RD>L' --aov z,Nn,albedo,id --cryptomatte object --statistics beauty=mse,even";
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\nlight = \"float\"\npreset = \"nuke\"\n");
    REQUIRE(run_raylex(folder, "render room.pbrt -o archive.exr --exr archive" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render room.pbrt -o nuke.exr --exr nuke" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render room.pbrt -o blender.exr --exr single --exr blender" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr" + layers).code == 0);
    const auto archive = read_exr(folder.path("archive.exr"));
    REQUIRE(archive);
    for (const std::string name : {"nuke", "blender", "job"}) {
        CAPTURE(name);
        const auto image = read_exr(folder.path(name + ".exr"));
        REQUIRE(image);
        const display::StoredType light =
            name == "job" ? display::StoredType::single_float : display::StoredType::half_float;
        CHECK(image->layer("direct")->planes[0].stored == light);
        // What compositors read as data has the bits of the archive.
        for (const char* data : {"z", "id", "CryptoObject00", "beauty_mse", "beauty_even"}) {
            CAPTURE(data);
            const display::ImageLayer *here = image->layer(data), *there = archive->layer(data);
            if (here == nullptr) here = image->layer("Z");  // in a single part
            REQUIRE((here != nullptr && there != nullptr));
            CHECK(here->planes[0].stored != display::StoredType::half_float);
            CHECK(here->planes[0].values == there->planes[0].values);
        }
        const Outcome verify = run_raylex(folder, "verify " + name + ".exr");
        CAPTURE(verify.out);
        CHECK(verify.code == 0);
        CHECK(contains(verify.out, "holds to rounding"));
        CHECK(contains(verify.out, name == "job" ? "(float, 2^-23)" : "(half, 2^-10)"));
    }
    // Nuke requires the compression of part 0 in all parts.
    const Imf::MultiPartInputFile nuke(folder.path("nuke.exr").c_str());
    for (int part = 0; part < nuke.parts(); ++part) CHECK(nuke.header(part).compression() == Imf::ZIPS_COMPRESSION);
    CHECK(std::string(nuke.header(nuke.parts() - 1).name()) == "id");
    check_refused(folder, "render room.pbrt -o x.exr --exr nuk", {"did you mean 'nuke'?"});
    check_refused(folder, "render room.pbrt -o x.exr --exr nuke --exr position=half", {"position", "expected float"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\npreset = \"nuk\"\n");
    check_refused(folder, "render bad.toml -o x.exr", {"bad.toml:4", "did you mean 'nuke'?"});
}

TEST_CASE("lossy layers are allowed, and verify accounts for the loss", "[law1]") {
    const SceneFolder folder;
    const std::string layers = " --lpe direct='C.L' --aov z --partition shipped";
    REQUIRE(run_raylex(folder, "render room.pbrt -o float.exr" + layers).code == 0);
    REQUIRE(run_raylex(folder, "render room.pbrt -o strong.exr --exr light='half dwaa:90'" + layers).code == 0);
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[exr]\nlight = \"dwab\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr" + layers).code == 0);
    for (const auto& [file, storage, level] : {std::array<const char*, 3>{"strong.exr", "half dwaa:90", "level 90"},
                                               {"job.exr", "float dwab:45", "level 45"}}) {
        CAPTURE(file);
        auto image = read_exr(folder.path(file));
        REQUIRE(image);
        CHECK(image->attributes["storage/direct"] == storage);
        CHECK(image->attributes["storage/z"] == "float zip");
        CHECK(image->attributes["verdict/shipped"].starts_with("not judged while writing: "));
        CHECK(image->layer("direct")->planes[0].loss == display::PlaneLoss::dwa);
        const Outcome outcome = run_raylex(folder, std::string("verify ") + file);
        CAPTURE(outcome.out);
        CHECK(outcome.code == 0);
        CHECK(contains(outcome.out, level));
    }
    auto exact = read_exr(folder.path("float.exr")), lossy = read_exr(folder.path("job.exr"));
    REQUIRE((exact && lossy));
    CHECK(exact->layer("z")->planes[0].values == lossy->layer("z")->planes[0].values);
    CHECK(exact->layer("direct")->planes[0].values != lossy->layer("direct")->planes[0].values);
}
