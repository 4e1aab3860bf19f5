// The density of a guide (paths/guide/): it integrates to 1, it is that of its samples, and it is learned to the same
// bits by any number of threads.
#include <algorithm>
#include <numbers>
#include <thread>

#include "tests/support/paths.h"
#include "tests/transport/materials_support.h"
#include "transport/guide/guide_support.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/paths/guide/direction_square.h"
#include "transport/paths/guide/guide.h"
#include "transport/paths/guide/guide_sums.h"
#include "transport/render/stages/prepared_job.h"

using namespace render_test;

namespace {

using raylex::test::Random;
using transport::GuideRecord;
using transport::GuideSums;
using transport::GuideTree;
using transport::Real;
using transport::Vec2;
using transport::Vec3;

const transport::Bounds unit_box{{0, 0, 0}, {1, 1, 1}};
constexpr double sphere_area = 4 * std::numbers::pi;
/// Of the integral of a density: up to 12 shares and the area of the square per steradian, each rounded by 2^-24 of its
/// value.
constexpr double density_rounding = 5e-6;

/// Light from a spot of 7 degrees around a direction that turns with the position, and a little from everywhere. Half
/// of the directions come from the guide.
GuideRecord spot_record(Random& random, const GuideTree& tree, std::uint64_t key) {
    GuideRecord record;
    record.position = {random.one(), random.one(), random.one()};
    record.normal = random.one() < 0.5f ? Vec3{0, 1, 0} : Vec3{0, 0, 0};
    const GuideTree::Region& region = tree.region(tree.place_of(record.position, record.normal).region);
    record.direction = random.one() < region.share ? tree.sample(region, random.two())
                                                   : transport::sample_uniform_sphere(random.two());
    record.chance = double{region.share * tree.density(region, record.direction) +
                           (1 - region.share) * transport::uniform_sphere_pdf()};
    record.density = record.chance;
    const Real around = record.position.x;
    const Vec3 spot{std::cos(around), std::sin(around), 0};
    const double light = dot(record.direction, spot) > 0.9925f ? 1 : 1e-3;
    record.square = light * light / (record.chance * record.chance);
    record.key = key;
    return record;
}

GuideTree taught(unsigned threads) {
    GuideTree tree(unit_box);
    for (std::uint64_t round = 0; round < 4; ++round) {
        GuideSums sums(tree);
        std::vector<std::thread> running;
        for (unsigned t = 0; t < threads; ++t)
            running.emplace_back([&, t] {
                for (std::uint64_t i = t; i < 40'000; i += threads) {
                    Random random(round * 100'000 + i);
                    sums.add(spot_record(random, tree, i));
                }
            });
        for (std::thread& thread : running) thread.join();
        tree = refined(sums, {.finds = 500, .nodes = 100'000, .final = round == 3, .cost = 1.2});
    }
    return tree;
}

/// The integral over the sphere: squares of the map that are not within one cell are divided.
double integral(const GuideTree& tree, const GuideTree::Region& region, double x, double y, double size, int& cells) {
    const auto direction = [&](double u, double v) {
        return transport::direction_from_square({static_cast<Real>(x + u * size), static_cast<Real>(y + v * size)});
    };
    const std::size_t cell = tree.cell_of(region, direction(0.25, 0.25));
    if (cell == tree.cell_of(region, direction(0.75, 0.25)) && cell == tree.cell_of(region, direction(0.25, 0.75)) &&
        cell == tree.cell_of(region, direction(0.75, 0.75))) {
        ++cells;
        const Vec3 centre = direction(0.5, 0.5);
        return double{tree.density(region, centre) / transport::square_per_steradian(centre)} * size * size;
    }
    double sum = 0;
    for (const double u : {0.0, 0.5})
        for (const double v : {0.0, 0.5}) sum += integral(tree, region, x + u * size, y + v * size, size / 2, cells);
    return sum;
}

/// Chi-squared of `count` directions against a density, over 32 x 32 parts of the square; in standard deviations from
/// its mean. `draw` returns a direction, or zero for a path that ends, which the rest of the density stands for.
template <class Draw, class Density>
double chi_squared(int count, const Draw& draw, const Density& density) {
    constexpr int parts = 32, within = 8;
    std::vector<double> found(parts * parts), expected(parts * parts);
    double rest_found = 0, rest_expected = count;
    for (int i = 0; i < count; ++i) {
        const Vec3 direction = draw();
        if (direction == Vec3{0, 0, 0}) {
            ++rest_found;
            continue;
        }
        const Vec2 at = transport::square_from_direction(direction);
        const auto part = [](Real x) { return std::min(static_cast<int>(x * parts), parts - 1); };
        ++found[static_cast<std::size_t>(part(at.y) * parts + part(at.x))];
    }
    for (int y = 0; y < parts * within; ++y)
        for (int x = 0; x < parts * within; ++x) {
            const Vec3 direction = transport::direction_from_square(
                {(static_cast<Real>(x) + 0.5f) / (parts * within), (static_cast<Real>(y) + 0.5f) / (parts * within)});
            expected[static_cast<std::size_t>(y / within * parts + x / within)] +=
                density(direction) / double{transport::square_per_steradian(direction)} * count /
                (parts * parts * within * within);
        }
    double sum = 0;
    int degrees = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (expected[i] < 10) {
            rest_found += found[i];
            continue;
        }
        rest_expected -= expected[i];
        sum += (found[i] - expected[i]) * (found[i] - expected[i]) / expected[i];
        ++degrees;
    }
    if (rest_expected > 10) {
        sum += (rest_found - rest_expected) * (rest_found - rest_expected) / rest_expected;
        ++degrees;
    }
    return (sum - degrees) / std::sqrt(2.0 * degrees);
}

/// Chi-squared of 20,000 directions of a region's quadtree.
template <class Density>
double chi_squared_of(const GuideTree& tree, const GuideTree::Region& region, Random& random, const Density& density) {
    return chi_squared(
        20'000, [&] { return tree.sample(region, random.two()); }, density);
}

/// Closures of all kinds that a guide draws for.
std::vector<transport::Bsdf> guided_closures(const raylex::test::Frame& frame) {
    std::vector<transport::Bsdf> closures(4);
    closures[0].set(frame, transport::LambertClosure{transport::Rgb(0.6f)});
    closures[1].set_phase(0.4f);
    closures[2].set(frame, transport::DiffuseTransmissionClosure{transport::Rgb(0.3f), transport::Rgb(0.4f)});
    closures[3].set(frame, transport::ConductorClosure{transport::Ggx::from_alpha(0.2f, 0.3f), transport::Rgb(0.8f),
                                                       transport::Rgb(0), true});
    return closures;
}

/// The guide that a render of the scene with 72 x 72 pixels learns; null if no region of it is guided.
transport::TrainedGuide learned(const transport::SceneDescription& description, int samples) {
    const auto scene = transport::BuiltScene::build(description);
    REQUIRE(scene.ok());
    transport::RenderSettings settings = guided_settings(samples, 1);
    settings.film.resolution = {72, 72};
    auto job = transport::ResolvedJob::resolve(**scene, settings);
    REQUIRE(job.ok());
    auto prepared = transport::PreparedJob::prepare(*std::move(job));
    REQUIRE(prepared.ok());
    return std::move(prepared->guide);
}

}  // namespace

TEST_CASE("the density of each region of a guide integrates to 1, and samples have it", "[guide]") {
    const GuideTree tree = taught(1);
    REQUIRE(tree.regions().size() > 50);
    Random random(3);
    int guided = 0, most_cells = 0;
    for (const GuideTree::Region& region : tree.regions()) {
        int cells = 0;
        CHECK(integral(tree, region, 0, 0, 1, cells) == Approx(1).margin(density_rounding));
        most_cells = std::max(most_cells, cells);
        if (region.share > 0) ++guided;
    }
    CHECK(guided > 50);
    CHECK(most_cells > 30);
    for (std::size_t i = 0; i < tree.regions().size(); i += 10) {
        const GuideTree::Region& region = tree.regions()[i];
        // Beyond 6 standard deviations by chance less than once in 10^5, at the tails of some hundred degrees of
        // freedom.
        CHECK(chi_squared_of(tree, region, random, [&](const Vec3& to) { return double{tree.density(region, to)}; }) <
              6);
    }
}

TEST_CASE("the cells of a region have the shares of its density, and regions have their sides", "[guide]") {
    const GuideTree tree = taught(1);
    const std::vector<std::uint8_t> sides = tree.sides();
    REQUIRE(sides.size() == tree.regions().size());
    const std::vector<Vec3> normals{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, 0}};
    Random random(11);
    for (int i = 0; i < 20; ++i)
        for (std::size_t side = 0; side < normals.size(); ++side)
            CHECK(sides[tree.place_of({random.one(), random.one(), random.one()}, normals[side]).region] == side);
    constexpr int parts = 32;
    for (std::size_t i = 0; i < tree.regions().size(); i += 20) {
        const GuideTree::Region& region = tree.regions()[i];
        const std::vector<Real> shares = tree.shares_of_cells(region, 5);
        REQUIRE(shares.size() == parts * parts);
        double sum = 0;
        int cells = 0;
        for (int y = 0; y < parts; ++y)
            for (int x = 0; x < parts; ++x) {
                const double share = double{shares[static_cast<std::size_t>(parts * y + x)]};
                sum += share;
                // Both are products of up to 12 shares, each rounded by 2^-24 of its value.
                CHECK(share == Approx(integral(tree, region, double(x) / parts, double(y) / parts, 1.0 / parts, cells))
                                   .epsilon(5e-6)
                                   .margin(1e-12));
            }
        CHECK(sum == Approx(1).margin(5e-6));
    }
}

TEST_CASE("a wrong density of a guide is found by its samples", "[guide]") {
    const GuideTree tree = taught(1);
    Random random(3);
    for (std::size_t i = 0; i < tree.regions().size(); i += 20) {
        const GuideTree::Region& region = tree.regions()[i];
        if (!(region.share > 0)) continue;
        // A tenth of all samples is taken for uniform.
        CHECK(chi_squared_of(tree, region, random, [&](const Vec3& to) {
                  return 0.9 * double{tree.density(region, to)} + 0.1 / sphere_area;
              }) > 6);
    }
}

TEST_CASE("a guide learns where light comes from, and that it pays there", "[guide]") {
    const GuideTree tree = taught(1);
    for (const Real x : {0.1f, 0.4f, 0.9f}) {
        const GuideTree::Region& region = tree.region(tree.place_of({x, 0.4f, 0.6f}, {0, 1, 0}).region);
        const Vec3 spot{std::cos(x), std::sin(x), 0};
        // Means over cones: a cell alone has learned from a few records.
        Random random(7);
        Real towards = 0, away = 0;
        constexpr int directions = 256;
        for (int i = 0; i < directions; ++i) {
            const Vec3 other = transport::sample_uniform_sphere(random.two()), near = normalize(spot + other * 0.1f);
            towards += tree.density(region, near) / directions;
            away += tree.density(region, -near) / directions;
        }
        CAPTURE(x, region.share, towards, away);
        CHECK(region.share >= 0.25f);
        // The spot is 1 / 270 of the sphere, and the ideal density there 200 times that of the sphere. Regions are wide
        // enough for it to move by its own width.
        CHECK(towards > 20 * transport::uniform_sphere_pdf());
        CHECK(away < transport::uniform_sphere_pdf());
    }
    // Surfaces that no record was at stay with their closures.
    CHECK(tree.region(tree.place_of({0.5f, 0.5f, 0.5f}, {1, 0, 0}).region).share == 0);
}

TEST_CASE("a guide has the same bits for every number of threads that teach it", "[guide][law3]") {
    const GuideTree one = taught(1);
    for (const unsigned threads : {2u, 3u, 8u}) {
        const GuideTree other = taught(threads);
        REQUIRE(other.regions().size() == one.regions().size());
        Random random(9);
        for (std::size_t i = 0; i < one.regions().size(); ++i) {
            const Vec3 to = transport::sample_uniform_sphere(random.two());
            CHECK(one.regions()[i].share == other.regions()[i].share);
            CHECK(one.density(one.regions()[i], to) == other.density(other.regions()[i], to));
        }
    }
}

TEST_CASE("a guide stays below its bound of nodes", "[guide]") {
    GuideTree tree(unit_box);
    GuideSums sums(tree);
    for (std::uint64_t i = 0; i < 20'000; ++i) {
        Random random(i);
        sums.add(spot_record(random, tree, i));
    }
    CHECK(refined(sums, {.finds = 10, .nodes = 1'000'000}).node_count() > 20'000);
    CHECK(refined(sums, {.finds = 10, .nodes = 5'000}).node_count() <= 5'000);
    // Fewer nodes than the regions have already: the tree stays as it is.
    const GuideTree fine = refined(sums, {.finds = 10, .nodes = 1'000'000});
    const GuideSums again(fine);
    CHECK(refined(again, {.finds = 10, .nodes = 100}).node_count() == fine.node_count());
}

TEST_CASE("points outside the box, and no points, are in the regions at its border", "[guide]") {
    const GuideTree tree = taught(1);
    const Vec3 up{0, 1, 0};
    CHECK(tree.place_of({-5, 0.5f, 0.5f}, up).region == tree.place_of({0, 0.5f, 0.5f}, up).region);
    CHECK(tree.place_of({9, 0.5f, 0.5f}, up).region == tree.place_of({0.999999f, 0.5f, 0.5f}, up).region);
    const Real nan = std::numeric_limits<Real>::quiet_NaN();
    CHECK(tree.place_of({nan, 0.5f, 0.5f}, up).region == tree.place_of({0, 0.5f, 0.5f}, up).region);
}

TEST_CASE("a guide's samples have the density that pdf() returns, at closures of all kinds", "[guide][directions]") {
    const transport::Guide guide(taught(1));
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    Random random(5);
    for (const transport::Bsdf& bsdf : guided_closures(frame))
        for (int i = 0; i < 2000; ++i) {
            transport::SurfacePoint point;
            point.position = {random.one(), random.one(), random.one()};
            point.shading_normal = {0, 1, 0};
            point.wo = frame.to_world(raylex::test::local_direction(0.6f));
            const auto s = guide.sample(bsdf, point, transport::TransportMode::radiance, random.one(), random.two());
            if (!(s.pdf > 0)) continue;
            REQUIRE(s.is_weighed);
            CHECK(s.pdf == guide.pdf(bsdf, point, transport::TransportMode::radiance, s.wi, bsdf.pdf(point.wo, s.wi)));
            const auto f = bsdf.evaluate(point.wo, s.wi);
            // Products and quotients of a few floats.
            for (int c = 0; c < 3; ++c) CHECK(s.weight[c] * s.pdf == Approx(f.value[c]).epsilon(1e-4).margin(1e-6));
        }
}

TEST_CASE("directions of a guide have its mixed density, and a planted wrong one is found", "[guide][directions]") {
    const transport::Guide guide(taught(1));
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    constexpr auto radiance = transport::TransportMode::radiance;
    Random random(11);
    for (const transport::Bsdf& bsdf : guided_closures(frame)) {
        transport::SurfacePoint point;
        point.wo = frame.to_world(raylex::test::local_direction(0.6f));
        for (const Real x : {0.1f, 0.5f, 0.9f}) {
            const std::uint32_t region = guide.tree().place_of({x, 0.4f, 0.6f}, {0, 1, 0}).region;
            REQUIRE(guide.tree().region(region).share > 0);
            point.direction_region = 1 + region;
            const auto draw = [&] {
                const auto s = guide.sample(bsdf, point, radiance, random.one(), random.two());
                return s.pdf > 0 ? s.wi : Vec3{0, 0, 0};
            };
            // Paths end where the closure scatters no light.
            const auto density = [&](const Vec3& to) {
                const auto f = bsdf.evaluate(point.wo, to);
                return f.value.is_black() ? 0 : double{guide.pdf(bsdf, point, radiance, to, f.pdf)};
            };
            CHECK(chi_squared(20'000, draw, density) < 6);  // beyond 6 by chance less than once in 10^5
            // A fifth of the directions is taken for uniform; those of the quadtree are taken for the closure's.
            CHECK(chi_squared(20'000, draw, [&](const Vec3& to) { return 0.8 * density(to) + 0.2 / sphere_area; }) > 6);
            CHECK(chi_squared(20'000, draw, [&](const Vec3& to) { return double{bsdf.pdf(point.wo, to)}; }) > 6);
        }
    }
}

TEST_CASE("in five scenes 10,000 regions have densities that integrate to 1 and are pdf() of their samples",
          "[guide][gate]") {
    std::vector<transport::SceneDescription> scenes{scene_of(room), scene_of(foggy_room())};
    for (const char* name : {"door-ajar", "cornell-fog", "glass-fixtures"}) {
        auto scene = transport::import_pbrt(raylex::test::source_dir() + "/experiments/scenes/" + name + "/scene.pbrt");
        REQUIRE(scene.ok());
        scenes.push_back(*std::move(scene));
    }
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    const std::vector<transport::Bsdf> closures = guided_closures(frame);
    transport::SurfacePoint point;
    point.wo = frame.to_world(raylex::test::local_direction(0.6f));
    std::size_t regions = 0, guided = 0;
    Random random(1);
    for (const transport::SceneDescription& scene : scenes) {
        const transport::TrainedGuide trained = learned(scene, 128);
        REQUIRE(trained.guide != nullptr);
        const transport::Guide& guide = *trained.guide;
        const std::size_t count = guide.tree().regions().size();
        std::size_t right_integrals = 0, right_densities = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const GuideTree::Region& region = guide.tree().regions()[i];
            int cells = 0;
            right_integrals +=
                std::abs(integral(guide.tree(), region, 0, 0, 1, cells) - 1) <= density_rounding ? 1u : 0u;
            guided += region.share > 0 ? 1u : 0u;
            point.direction_region = static_cast<std::uint32_t>(1 + i);
            bool right = true;
            for (const transport::Bsdf& bsdf : closures) {
                constexpr auto radiance = transport::TransportMode::radiance;
                const auto s = guide.sample(bsdf, point, radiance, random.one(), random.two());
                right = right &&
                        (!(s.pdf > 0) || s.pdf == guide.pdf(bsdf, point, radiance, s.wi, bsdf.pdf(point.wo, s.wi)));
                // A direction drawn from the quadtree itself.
                const Vec3 to = guide.tree().sample(region, random.two());
                const Real by_closure = bsdf.pdf(point.wo, to), by_tree = guide.tree().density(region, to);
                right = right && by_tree > 0 &&
                        guide.pdf(bsdf, point, radiance, to, by_closure) ==
                            Approx(region.share * by_tree + (1 - region.share) * by_closure).epsilon(1e-6);
            }
            right_densities += right ? 1u : 0u;
        }
        CHECK(right_integrals == count);
        CHECK(right_densities == count);
        regions += count;
    }
    CHECK(regions >= 10'000);
    CHECK(guided >= 4'000);
}
