// NanoVDB files that the library itself writes, and damaged ones.
#include "tests/transport/media/grid_media_support.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

#include <cmath>
#include <filesystem>

#include "transport/color/spectrum.h"
#include "transport/files/nanovdb_file.h"

using namespace grid_media_test;
using import_test::contains;
using import_test::Folder;

namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

float density_at(int x, int y, int z) {
    return float(1 + (x * 7 + y * 13 + z * 29) % 11) / 8;
}

template <class Build = float>
Handle density_grid(const std::string& name = "density") {
    nanovdb::GridBuilder<float, Build> builder(0.0f, nanovdb::GridClass::FogVolume);
    auto accessor = builder.getAccessor();
    for (int z = -3; z < 13; ++z)
        for (int y = 0; y < 9; ++y)
            for (int x = 60; x < 75; ++x) accessor.setValue({x, y, z}, density_at(x, y, z));
    accessor.setValue({300, 0, 0}, 2.0f);  // far away: nearly everything is empty
    return builder.getHandle(0.5, nanovdb::Vec3d(-32, 0, 1), name);
}

Handle temperature_grid() {
    nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
    auto accessor = builder.getAccessor();
    for (int z = 0; z < 12; ++z)
        for (int y = -4; y < 12; ++y)
            for (int x = 0; x < 12; ++x) accessor.setValue({x, y, z}, 20.0f + float(x));
    return builder.getHandle(1.0, nanovdb::Vec3d(-3, 0, -1), "temperature");
}

void write(const std::string& path, std::vector<Handle> handles, nanovdb::io::Codec codec = nanovdb::io::Codec::NONE) {
    nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(path, handles, codec);
}

std::string medium(const std::string& path, const std::string& more = "") {
    return "\"string type\" \"nanovdb\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [0 0 1] \"string filename\" \"" + path +
           "\" " + more;
}

/// The world position of the density's voxel (x, y, z).
DVec3 place(double x, double y, double z) {
    return {x * 0.5 - 32, y * 0.5, z * 0.5 + 1};
}

std::vector<Handle> handles(Handle first) {
    std::vector<Handle> list;
    list.push_back(std::move(first));
    return list;
}

}  // namespace

TEST_CASE("nanovdb files of the library are read, packed and unpacked", "[media][grids][nanovdb]") {
    const Folder folder;
    for (const auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP}) {
        const std::string path = folder.path("smoke.nvdb");
        write(path, handles(density_grid()), codec);
        const Built built = build_medium(medium(path), "Translate 0 0 5");
        CHECK(built.warnings.empty());
        CHECK_FALSE(built.medium().emits);
        for (int z = -3; z < 13; ++z)
            for (int y = 0; y < 9; ++y)
                for (int x = 60; x < 75; ++x) {
                    const DVec3 p = place(x, y, z);
                    // Places are floats in cells, 2^-22 of a cell, and values change by 1.4 in a quarter of one.
                    CHECK(std::abs(built.at(p.x, p.y, p.z + 5).sigma_a.g - 2 * density_at(x, y, z)) <= 2e-4);
                }
        const DVec3 between = place(66.5, 3, 4), far = place(300, 0, 0), empty = place(200, 4, 4);
        CHECK(built.at(between.x, between.y, between.z + 5).sigma_s.b ==
              Approx((density_at(66, 3, 4) + density_at(67, 3, 4)) / 2).margin(2e-4));
        CHECK(built.at(far.x, far.y, far.z + 5).sigma_a.r == Approx(2).margin(2e-4));
        CHECK(built.at(empty.x, empty.y, empty.z + 5).sigma_a.is_black());
        CHECK(built.medium().grid->majorant(built.here(empty.x, empty.y, empty.z + 5)) == 0);
        // pbrt's box: from the coordinates of the first active voxel to one beyond the last.
        const DVec3 below = place(66, -0.25, 4);
        CHECK(built.at(below.x, below.y, below.z + 5).sigma_a.is_black());
        CHECK(built.media.grid_bytes() < 4'000'000);
    }
}

TEST_CASE("quantised nanovdb grids are read, too", "[media][grids][nanovdb]") {
    const Folder folder;
    const auto check = [&](Handle handle, double most_off) {
        const std::string path = folder.path("smoke.nvdb");
        write(path, handles(std::move(handle)));
        const Built built = build_medium(medium(path));
        for (int x = 60; x < 75; ++x) {
            const DVec3 p = place(x, 2, 3);
            CHECK(std::abs(built.at(p.x, p.y, p.z).sigma_a.r - density_at(x, 2, 3)) <= most_off);
        }
    };
    // Steps of a leaf's range, 1.4 here, dithered: one step.
    check(density_grid<nanovdb::Fp8>(), 1.4 / 255 + 2e-4);
    check(density_grid<nanovdb::Fp16>(), 1.4 / 65535 + 2e-4);
}

TEST_CASE("a grid of temperatures in a nanovdb file gives blackbodies", "[media][grids][nanovdb]") {
    const Folder folder;
    const std::string path = folder.path("fire.nvdb");
    std::vector<Handle> both = handles(density_grid());
    both.push_back(temperature_grid());
    write(path, std::move(both));
    const Built built = build_medium(
        medium(path, "\"float Lescale\" 0.5 \"float temperaturecutoff\" 2 \"float temperaturescale\" 100"));
    CHECK(built.medium().emits);
    const DVec3 p = place(66, 3, 4);  // (1, 1.5, 3) in the world; (4, 1.5, 4) in the temperature grid
    const Rgb expected = blackbody_radiance((20 + 4 - 2) * 100, built.scene.color);
    const MediumPoint here = built.at(p.x, p.y, p.z);
    // The table of blackbodies: 1e-4; the place in the density grid: 2e-4.
    for (int c = 0; c < 3; ++c)
        CHECK(here.emission[c] == Approx(double(here.sigma_a[c] * expected[c]) * 0.5).epsilon(5e-4));
    CHECK_FALSE(build_medium(medium(path, "\"float LeScale\" 0")).medium().emits);
}

TEST_CASE("grids of a nanovdb file are found by the names in the scene", "[media][grids][nanovdb]") {
    const Folder folder;
    const std::string path = folder.path("fire.nvdb");
    std::vector<Handle> both = handles(density_grid("smoke"));
    both.push_back(temperature_grid());
    write(path, std::move(both));
    const std::string smoke = "\"string gridname\" \"smoke\" ";
    CHECK(build_medium(medium(path, smoke + "\"float temperaturescale\" 100")).medium().emits);
    CHECK_FALSE(build_medium(medium(path, smoke + "\"string temperaturename\" \"heat\"")).medium().emits);
    CHECK(contains(refused_medium(medium(path)).message, "has no grid 'density'; it has: 'smoke', 'temperature'"));
}

TEST_CASE("large nanovdb tiles and backgrounds are neither read voxel by voxel nor stored", "[media][grids][nanovdb]") {
    const Folder folder;
    const std::string path = folder.path("tiles.nvdb");
    nanovdb::GridBuilder<float> tiles(0.0f, nanovdb::GridClass::FogVolume);
    tiles([](const nanovdb::Coord&) { return 3.0f; }, nanovdb::CoordBBox({0, 0, 0}, {127, 127, 255}));
    write(path, handles(tiles.getHandle(1.0, nanovdb::Vec3d(0, 0, 0), "density")));
    CHECK(std::filesystem::file_size(path) < 1'000'000);  // 4,194,304 voxels: nodes that are tiles
    const Built block = build_medium(medium(path));
    CHECK(block.at(64, 64, 100).sigma_a.r == 3);
    CHECK(block.at(64, 64, 128.5).sigma_a.r == 3);                            // where two tiles meet
    CHECK(block.at(127.25, 64, 100).sigma_a.r == Approx(2.25).margin(1e-4));  // and where they end
    CHECK(block.at(127.5, 127.5, 255.5).sigma_a.r == Approx(0.375).margin(1e-4));

    nanovdb::GridBuilder<float> wide(0.5f, nanovdb::GridClass::FogVolume);
    wide.getAccessor().setValue({0, 0, 0}, 1.0f);
    wide.getAccessor().setValue({790, 790, 790}, 2.0f);
    write(path, handles(wide.getHandle(1.0, nanovdb::Vec3d(0, 0, 0), "density")));
    const Built sea = build_medium(medium(path));
    CHECK(sea.at(0, 0, 0).sigma_a.r == 1);
    CHECK(sea.at(400, 300, 200).sigma_a.r == 0.5f);
    CHECK(sea.at(790, 790, 790).sigma_a.r == Approx(2).margin(1e-4));
    CHECK(sea.media.grid_bytes() < 100 * 100 * 100 * 24);  // a million cells, no voxels
}

TEST_CASE("errors of nanovdb files give the reason", "[media][grids][nanovdb][law7][gate]") {
    const Folder folder;
    write(folder.path("smoke.nvdb"), handles(density_grid()));
    write(folder.path("other.nvdb"), handles(density_grid("heat")));
    const std::string whole = folder.read("smoke.nvdb");
    CHECK(contains(refused_medium(medium(folder.path("other.nvdb"))).message, "has no grid 'density'; it has: 'heat'"));
    folder.write("text.nvdb", "this is no grid");
    CHECK(contains(refused_medium(medium(folder.path("text.nvdb"))).message, "not a readable NanoVDB file"));
    std::string older = whole;
    older[11] = 1;  // the 11 highest of a version's 32 bits are its major number
    folder.write("older.nvdb", older);
    CHECK(contains(refused_medium(medium(folder.path("older.nvdb"))).message,
                   "the file has NanoVDB version 8; expected"));
    // The size of packed data precedes it; memory of that size is allocated first.
    write(folder.path("packed.nvdb"), handles(density_grid()), nanovdb::io::Codec::ZIP);
    std::string packed = folder.read("packed.nvdb");
    const std::string size_of_it("\x78\x9c", 2);  // the first bytes of zlib data
    packed[packed.find(size_of_it, 16 + 176) - 2] = 0x7e;
    folder.write("packed.nvdb", packed);
    CHECK(contains(refused_medium(medium(folder.path("packed.nvdb"))).message, "larger than the grid"));
    const raylex::Error missing = import_test::error_of(medium_scene(medium("nowhere.nvdb"), ""));
    CHECK(contains(missing.message, "nowhere.nvdb"));
    CHECK(missing.line == 2);
    // A file of 300 KB whose tables refer to one node 32,768 times would have 69 thousand million voxels.
    Handle looped = density_grid();
    auto& upper = *const_cast<nanovdb::NanoTree<float>&>(looped.grid<float>()->tree()).getFirstNode<2>()->data();
    const std::int64_t child = upper.mTable[*upper.mChildMask.beginOn()].child;
    for (auto& entry : upper.mTable) entry.child = child;
    upper.mChildMask.setOn();
    write(folder.path("looped.nvdb"), handles(std::move(looped)));
    CHECK(contains(refused_medium(medium(folder.path("looped.nvdb"))).message, "its nodes overlap"));
    // Truncated files and files with wrong bytes give a message or a medium, and no signal. Offsets of nodes are in the
    // tables, values in leaves.
    for (std::size_t i = 1; i < 40; ++i) {
        folder.write("short.nvdb", whole.substr(0, whole.size() * i / 40));
        CHECK(refused_medium(medium(folder.path("short.nvdb"))).line == 2);
    }
    std::uint64_t state = 1;
    int read = 0;
    constexpr int trials = 300;
    for (int i = 0; i < trials; ++i) {
        std::string bytes = whole;
        state = state * 6364136223846793005u + 1442695040888963407u;
        // Headers and the first nodes of the tree contain the offsets that mislead most.
        const std::size_t at = state % std::min<std::size_t>(bytes.size() - 8, i % 2 == 0 ? 1200 : bytes.size() - 8);
        for (std::size_t k = 0; k < 8; ++k) bytes[at + k] = static_cast<char>(state >> (8 * k));
        folder.write("wrong.nvdb", bytes);
        auto grid = read_nanovdb_grid(folder.path("wrong.nvdb"), "density", false);
        if (grid.ok()) ++read;
        else CHECK_FALSE(grid.error().message.empty());
    }
    CHECK(read > 0);
    CHECK(read < trials);
}
