// Agreement with reference images by pbrt-v4.
//
// The short test compares the scenes that come with raylex with their published mean luminance. The long test needs the
// reference images, which do not come with raylex: RAYLEX_REFERENCES names their folder (default: ../shared/data/scenes
// beside the project). It prints a message if they are missing.
//
// Blocks of 16 x 16 pixels show structured errors: z = mean difference of the block's 256 pixels over its standard
// error, computed from the differences around their mean, so it contains the noise of both images. (An error spread
// over the image by its published RMSE was too small by a factor of four if the few brightest pixels dominate it.)
// Pixels are sampled independently in both images; correlations of samplers make neighbouring pixels err in opposite
// directions, which is on the safe side. Over B blocks, max |z| is compared with the two-sided Sidak threshold at 0.01,
// normal for 255 degrees of freedom.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "display/output/reader/exr_reader.h"
#include "endtoend/analytic.h"
#include "support/skip.h"
#include "tests/support/paths.h"

using namespace raylex;
using namespace raylex::test;
namespace fs = std::filesystem;

namespace {

struct ReferenceScene {
    const char* name;
    bool shipped;  ///< the scene file is in experiments/scenes
    bool grey;
    double mean_luminance;       ///< 0: not published
    double luminance_rmse;       ///< of the reference image; 0: not published
    double block_allowance = 0;  ///< relative, besides the noise: pbrt is spectral, and products of RGB colours differ
};

// Published with the references (data README): mean luminance, RMSE of luminance. The red wall (0.63 0.065 0.05) of
// bitterli-cornell-box under its yellow light (17 12 4) is 9.3 % brighter than pbrt's, evenly over the whole wall; its
// neutral walls agree within 1 %.
const ReferenceScene reference_scenes[] = {
    {"point-plane", true, true, 0.22134, 0.00009},
    {"furnace-sphere", true, true, 0.71992, 0.0007},
    {"furnace-box", true, true, 1.99587, 0.058},
    {"cornell-grey", true, true, 0.23711, 0.0043},
    {"cornell-fog", true, true, 0.08003, 0.0190},
    {"cornell-color", true, false, 0.23075, 0.0056, 0.03},
    {"mis-plates", true, true, 0.59076, 0.17},
    {"displaced-sphere-1m", false, true, 0.55752, 0.0094},
    {"still-life", true, true, 0, 0},
    {"sky-image", true, true, 0, 0},
    {"bitterli-cornell-box", false, false, 0.13031, 0.0035, 0.11},
    {"bitterli-veach-mis", false, false, 0.93147, 0.50, 0.03},
    {"bitterli-veach-bidir", false, false, 0.35630, 0.072, 0.03},
};

fs::path reference_folder() {
    if (const char* given = std::getenv("RAYLEX_REFERENCES")) return given;
    return fs::path(raylex::test::source_dir()) / ".." / "shared" / "data" / "scenes";
}

transport::SceneDescription load(const fs::path& file) {
    auto scene = transport::import_pbrt(file.string());
    INFO((scene ? std::string() : scene.error().to_string()));
    REQUIRE(scene.ok());
    return std::move(*scene);
}

std::vector<double> luminance_of(const std::vector<double>& rgb) {
    std::vector<double> result(rgb.size() / 3);
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = luminance(RgbD(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]));
    return result;
}

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / double(values.size());
}

struct BlockDifference {
    double reference = 0, difference = 0, error = 0;  ///< means, and the standard error of their difference
};

/// Compares blocks of 16 x 16 pixels, without incomplete blocks at the right and bottom.
std::vector<BlockDifference> differences(const std::vector<double>& own, const std::vector<double>& reference,
                                         int width, int height) {
    constexpr int side = 16;
    constexpr double pixels = side * side;
    std::vector<BlockDifference> result;
    for (int by = 0; by + side <= height; by += side)
        for (int bx = 0; bx + side <= width; bx += side) {
            BlockDifference& block = result.emplace_back();
            double squares = 0;
            for (int i = 0; i < side * side; ++i) {
                const std::size_t at = std::size_t(by + i / side) * std::size_t(width) + std::size_t(bx + i % side);
                const double d = own[at] - reference[at];
                block.reference += reference[at] / pixels;
                block.difference += d / pixels;
                squares += d * d;
            }
            const double variance = (squares - pixels * block.difference * block.difference) / (pixels - 1);
            block.error = std::sqrt(std::max(variance, 0.0) / pixels);
        }
    return result;
}

/// Returns the inverse of the standard normal distribution function by bisection on erfc.
double normal_quantile(double p) {
    double low = 0, high = 10;
    for (int i = 0; i < 80; ++i) {
        const double middle = (low + high) / 2;
        (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
    }
    return low;
}

}  // namespace

TEST_CASE("Shipped scenes have the mean luminance of pbrt-v4's references", "[reference][statistical][gate]") {
    for (const ReferenceScene& each : reference_scenes) {
        if (!each.shipped || each.mean_luminance == 0) continue;
        const auto scene =
            load(fs::path(raylex::test::source_dir()) / "experiments" / "scenes" / each.name / "scene.pbrt");
        transport::RenderSettings settings;
        settings.samples.per_pixel = 16;
        const auto output = render_or_fail(scene, settings);
        const auto pixels = luminance_of(output.frame_buffer.resolve(output.beauty));
        const double mean = mean_of(pixels);
        const auto variance = output.frame_buffer.resolve_variance_of_mean(output.beauty);
        double own = 0;
        for (const double v : variance) own += v / 3;
        const double own_error = std::sqrt(own) / double(pixels.size());
        const double reference_error = each.luminance_rmse / std::sqrt(double(pixels.size()));
        // 1 % (grey) or 3 % (coloured: pbrt is spectral) as systematic allowance, plus 4 standard errors of both.
        const double allowance = (each.grey ? 0.01 : 0.03) * each.mean_luminance;
        CAPTURE(each.name, mean, each.mean_luminance, own_error, reference_error);
        CHECK(std::abs(mean - each.mean_luminance) <= allowance + 4 * std::hypot(own_error, reference_error));
    }
}

TEST_CASE("Every reference scene agrees with its pbrt-v4 image in mean and in blocks", "[.full][reference][gate]") {
    if (!fs::exists(reference_folder())) RAYLEX_SKIP("no reference images; set RAYLEX_REFERENCES to their folder");
    for (const ReferenceScene& each : reference_scenes) {
        const fs::path folder = reference_folder() / each.name;
        const auto scene = load(folder / "scene.pbrt");
        auto reference_file = display::read_exr((folder / "reference.exr").string());
        INFO((reference_file ? std::string() : reference_file.error().to_string()));
        REQUIRE(reference_file.ok());
        const auto* layer = reference_file->layer("");
        REQUIRE(layer != nullptr);
        const auto planes = layer->triple();
        std::vector<double> reference(planes[0]->values.size());
        for (std::size_t i = 0; i < reference.size(); ++i)
            reference[i] = luminance(RgbD(planes[0]->values[i], planes[1]->values[i], planes[2]->values[i]));
        const int width = reference_file->width, height = reference_file->height;

        transport::RenderSettings settings;
        settings.samples.per_pixel = 512;
        settings.samples.seed = 1;
        const auto output = render_or_fail(scene, settings);
        REQUIRE(output.view.width == width);
        REQUIRE(output.view.height == height);
        const auto pixels = luminance_of(output.frame_buffer.resolve(output.beauty));
        const double ratio = mean_of(pixels) / mean_of(reference);
        const std::vector<BlockDifference> blocks = differences(pixels, reference, width, height);
        double worst = 0;
        std::size_t worst_block = 0;
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            // 1e-5 relative: both renderers compute in float, and noise-free blocks have no other error bar.
            const double systematic = each.block_allowance * blocks[b].reference;
            const double z = std::max(std::abs(blocks[b].difference) - systematic, 0.0) /
                             (blocks[b].error + 1e-5 * blocks[b].reference);
            if (z > worst) worst = z, worst_block = b;
        }
        const auto across = std::size_t(width / 16);
        const double threshold = normal_quantile(0.5 + 0.5 * std::pow(0.99, 1.0 / double(blocks.size())));
        std::cout << each.name << ": mean ratio " << ratio << ", worst block z " << worst << " at "
                  << worst_block % across * 16 << "," << worst_block / across * 16 << " (threshold " << threshold << ")"
                  << std::endl;
        CAPTURE(each.name, ratio, worst, worst_block, threshold);
        CHECK(std::abs(ratio - 1) <= (each.grey ? 0.01 : 0.03));
        CHECK(worst <= threshold);
    }
}
