#include "experiments/cli/judge.h"

#include <filesystem>

#include "experiments/cli/console.h"

namespace raylex::experiments {
namespace {

std::string target_name(const display::SplitVerdict& verdict) {
    return verdict.of.empty() ? "beauty" : verdict.of;
}

std::string layer_count(const display::SplitVerdict& verdict) {
    return std::to_string(verdict.layers.size()) + (verdict.layers.size() == 1 ? " layer" : " layers");
}

std::string pixel_text(int x, int y) {
    return "(" + std::to_string(x) + ", " + std::to_string(y) + ")";
}

std::string partition_name(const display::SplitVerdict& verdict) {
    return verdict.partition.empty() ? "the layers given" : "partition '" + verdict.partition + "'";
}

}  // namespace

std::string verdict_text(const display::SplitVerdict& verdict) {
    std::string text = partition_name(verdict) + ": " + layer_count(verdict) + " against " + target_name(verdict) +
                       (verdict.holds ? ": holds" : ": DOES NOT HOLD");
    text += "\n  largest absolute error " + number_text(verdict.largest_absolute, 6) + " at pixel " +
            pixel_text(verdict.absolute_x, verdict.absolute_y);
    text += "\n  largest relative error " + number_text(verdict.largest_relative, 6) + " at pixel " +
            pixel_text(verdict.relative_x, verdict.relative_y) + "; bound " + number_text(verdict.bound, 6) +
            (verdict.bound > 1e-5 ? " (half, 2^-10)" : " (float, 2^-23)");
    if (verdict.exceeding > 0)
        text += "\n  " + std::to_string(verdict.exceeding) +
                (verdict.exceeding == 1 ? " pixel exceeds the bound" : " pixels exceed the bound");
    if (verdict.non_finite > 0)
        text += "\n  " + std::to_string(verdict.non_finite) +
                (verdict.non_finite == 1 ? " pixel holds" : " pixels hold") +
                " values that are not finite, the first " + pixel_text(verdict.non_finite_x, verdict.non_finite_y);
    return text;
}

std::string verdict_line(const display::SplitVerdict& verdict) {
    return partition_name(verdict) + ": " + layer_count(verdict) +
           (verdict.holds ? (verdict.layers.size() == 1 ? " sums to " : " sum to ") : " DO NOT SUM to ") +
           target_name(verdict) + " (largest relative error " + number_text(verdict.largest_relative) + ", bound " +
           number_text(verdict.bound) + ")";
}

std::string write_residual_map(const display::SplitVerdict& verdict, const display::ExrImage& image) {
    namespace fs = std::filesystem;
    if (verdict.residual.empty()) return "no residual map: the image has no pixels";
    const fs::path source(image.path);
    const fs::path name =
        source.stem().string() + "." + (verdict.partition.empty() ? "sum" : verdict.partition) + ".residual.png";
    std::string reason;
    for (const fs::path& path : {source.parent_path() / name, name}) {
        Status written = display::write_residual_png(path.string(), verdict, image.width, image.height);
        if (written)
            return "residual map: " + path.string() + " (blue to violet within the bound, red to yellow above it)";
        reason = written.error().message;
    }
    return "no residual map: " + reason;
}

}  // namespace raylex::experiments
