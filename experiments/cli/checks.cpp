#include "experiments/cli/checks.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "display/output/atomic_file.h"
#include "display/output/comparison/comparison.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/stored_precision.h"
#include "display/services/parameters.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/tint.h"
#include "experiments/verify/rebuild_lines.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

std::string target_name(const display::SplitResult& result) {
    return result.of.empty() ? "beauty" : result.of;
}

std::string layer_count(const display::SplitResult& result) {
    return std::to_string(result.layers.size()) + (result.layers.size() == 1 ? " layer" : " layers");
}

std::string pixel_text(int x, int y) {
    return "(" + std::to_string(x) + ", " + std::to_string(y) + ")";
}

std::string partition_name(const display::SplitResult& result) {
    return result.partition.empty() ? "the layers given" : "partition '" + result.partition + "'";
}

const char* answer_text(const display::SplitResult& result) {
    switch (result.answer) {
        case display::SplitAnswer::holds_to_rounding:
            return "holds to rounding";
        case display::SplitAnswer::holds_as_allowed:
            return "holds within what is allowed";
        case display::SplitAnswer::does_not_hold:
            return "DOES NOT HOLD";
        case display::SplitAnswer::cannot_tell:
            return "CANNOT TELL: every pixel is clamped";
    }
    return "";
}

std::string reasons(const display::SplitResult& result) {
    std::string text;
    for (const std::string& reason : result.allowed_for) text += (text.empty() ? "" : ", ") + reason;
    return text;
}

// Returns what the check allowed beyond rounding and how many pixels need it; empty if it allowed nothing.
std::string allowance_text(const display::SplitResult& result) {
    if (result.allowed_for.empty() || result.answer == display::SplitAnswer::holds_to_rounding) return {};
    std::string text = "\n  allowed on top: ";
    if (result.allowance.absolute > 0) text += "absolute " + number_text(result.allowance.absolute) + ", ";
    if (result.allowance.relative > 0) text += "relative " + number_text(result.allowance.relative) + ", ";
    text += "for " + reasons(result);
    if (result.past_rounding > 0)
        text += "; " + std::to_string(result.past_rounding) +
                (result.past_rounding == 1 ? " pixel needs it" : " pixels need it");
    return text;
}

fs::path residual_map_path(const display::SplitResult& result, const display::ExrImage& image) {
    const fs::path source(image.path);
    std::string name = result.partition.empty() ? "sum" : result.partition;
    std::replace(name.begin(), name.end(), '/', '_');
    return source.parent_path() / (source.stem().string() + "." + name + ".residual.png");
}

/// The path of the image of unassigned light beside a residual map.
std::string unassigned_path(const fs::path& map) {
    return fs::path(map).replace_extension().replace_extension(".unassigned.exr").string();
}

/// Writes the unassigned light beside a residual map. Returns a line about it; empty if there is none.
std::string write_unassigned(const fs::path& map, const display::SplitResult& result, const display::ExrImage& image) {
    if (result.rebuild.light.empty()) return {};
    const std::string path = unassigned_path(map);
    const Status written = display::write_unassigned_exr(path, result, image);
    return written
               ? "\n  light to add to the sum and to remove from it: " + path + " (layers unassigned, counted_twice)"
               : "\n  no image of unassigned light: " + written.error().message;
}

std::string clamped_text(const display::SplitResult& result) {
    return counted(result.clamped, "pixel") +
           " with values clamped to the largest half or float, which are lower bounds: " +
           std::to_string(result.checked()) + " of " + counted(result.pixels, "pixel") + " judged";
}

}  // namespace

std::string clamped_text(std::size_t pixels, const std::string& what) {
    return counted(pixels, "pixel") +
           " with values clamped to the largest half or float; for them the file does not show whether " + what;
}

std::string result_text(const display::SplitResult& result, const std::string& title) {
    std::string text = (title.empty() ? partition_name(result) : title) + ": " + layer_count(result) + " against " +
                       target_name(result) + ": " + answer_text(result);
    text += "\n  largest absolute error " + number_text(result.largest_absolute, 6) + " at pixel " +
            pixel_text(result.absolute_x, result.absolute_y);
    text += "\n  largest relative error " + number_text(result.largest_relative, 6) + " at pixel " +
            pixel_text(result.relative_x, result.relative_y) + "; bound " + number_text(result.bound, 6) + " (" +
            result.bound_reason + ")";
    text += allowance_text(result);
    if (result.exceeding > 0)
        text += "\n  " + std::to_string(result.exceeding) +
                (result.exceeding == 1 ? " pixel exceeds " : " pixels exceed ") +
                (result.allowed_for.empty() ? "the bound" : "what is allowed") +
                (result.never_above ? "; the sum is never larger than the beauty, so light is missing from the layers"
                                    : "");
    for (const std::string& line : rebuild_lines(result)) text += "\n  " + line;
    if (result.non_finite > 0)
        text += "\n  " + std::to_string(result.non_finite) +
                (result.non_finite == 1 ? " pixel holds" : " pixels hold") + " values that are not finite, the first " +
                pixel_text(result.non_finite_x, result.non_finite_y) +
                (result.non_finite_layer.empty() ? std::string() : " in " + result.non_finite_layer);
    if (result.clamped > 0) text += "\n  " + clamped_text(result);
    if (!result.holds)
        for (const std::string& lossy : result.unexplained)
            text +=
                "\n  " + lossy + " compression loses bits, and no tolerance covers that; --tolerance ABS,REL sets one";
    return text;
}

std::string result_line(const display::SplitResult& result) {
    if (result.answer == display::SplitAnswer::cannot_tell)
        return partition_name(result) + ": " + answer_text(result) + "; " + clamped_text(result);
    return partition_name(result) + ": " + layer_count(result) +
           (result.holds ? (result.layers.size() == 1 ? " sums to " : " sum to ") : " DO NOT SUM to ") +
           target_name(result) +
           (result.answer == display::SplitAnswer::holds_as_allowed ? " within what is allowed for " + reasons(result)
                                                                    : std::string()) +
           " (largest relative error " + number_text(result.largest_relative) + ", bound " + number_text(result.bound) +
           ")" + (result.clamped > 0 ? "; " + clamped_text(result) : std::string());
}

std::string repaired_text(const std::map<std::string, std::string>& attributes, const std::string& remedy) {
    constexpr std::string_view prefix = "repaired/";
    constexpr std::size_t most = 4;
    std::string text;
    std::size_t count = 0;
    for (const auto& [name, what] : attributes)
        if (name.starts_with(prefix) && ++count <= most)
            text += (text.empty() ? "" : "; ") + name.substr(prefix.size()) + ": " + what;
    if (count == 0) return {};
    return "the file cannot hold all values of " + counted(count, "layer") + ": " + text +
           (count > most ? "; ..." : "") +
           (text.find("beyond half") == std::string::npos ? "" : ". " + remedy + " stores larger values");
}

std::string write_residual_map(const display::SplitResult& result, const display::ExrImage& image) {
    if (result.residual.empty()) return "no residual map: the image has no pixels";
    const fs::path beside = residual_map_path(result, image);
    std::string reason;
    for (const fs::path& path : {beside, beside.filename()}) {
        Status written = display::write_residual_png(path.string(), result, image.width, image.height);
        if (written)
            return "residual map: " + path.string() + " (blue to violet within the bound, red to yellow above it)" +
                   write_unassigned(path, result, image);
        reason = written.error().message;
    }
    return "no residual map: " + reason;
}

bool print_results_of_new(std::span<const display::SplitResult> results, const display::ExrImage& image) {
    bool hold = true;
    for (const display::SplitResult& result : results) {
        print_result(result_line(result), result.holds);
        hold = hold && result.holds;
        const std::string map = residual_map_path(result, image).string();
        if (result.answer == display::SplitAnswer::does_not_hold) {
            print_line("  " + write_residual_map(result, image));
            continue;
        }
        for (const std::string& old : {map, unassigned_path(map)})
            if (Status removed = display::remove_file(old); !removed) print_warning(removed.error().to_string());
    }
    return hold;
}

std::string atlas_line(const display::AtlasCheck& result, std::uint64_t pixels) {
    std::string line = "atlas: " + std::to_string(result.words) + " path strings, " +
                       number_text(static_cast<double>(result.samples) / static_cast<double>(pixels), 3) +
                       " a pixel and at most " + std::to_string(result.most_samples) +
                       (result.holds ? ", sum to the beauty" : ", DO NOT SUM to the beauty") + " (largest error " +
                       number_text(result.largest) + " of the sum of magnitudes)";
    if (result.exceeding > 0) line += "; " + std::to_string(result.exceeding) + " pixels exceed the bound 2^-23";
    if (result.clamped > 0) line += "; " + clamped_text(result.clamped, "path strings sum to it");
    return line;
}

int report_atlas_check(display::AtlasFile& file) {
    file.read_parts(false);
    auto result = display::check_atlas(file, display::light_magnitude_of(file.description().attributes));
    if (!result) return report_error(result.error());
    const auto pixels = static_cast<std::uint64_t>(file.width()) * static_cast<std::uint64_t>(file.height());
    print_result(file.path() + ": " + atlas_line(*result, pixels), result->holds);
    return result->holds ? exit_holds : exit_does_not_hold;
}

Status check_new_exr(const std::string& output, std::span<const std::string> inputs) {
    if (fs::path(output).extension() != ".exr")
        return error_at({}, "the output '" + output + "' does not end in .exr; expected an OpenEXR file name");
    for (const std::string& input : inputs) {
        std::error_code failed;
        if (!input.empty() && (input == output || fs::equivalent(input, output, failed)))
            return error_at({}, "'" + input + "' is an input and would be overwritten; expected a different file");
    }
    return display::check_writable(output);
}

int check_new_image(const std::string& path) {
    auto file = display::ExrBands::open(path);
    if (!file) return report_error(file.error());
    const display::ExrImage& image = file->image();
    if (const std::string repaired = repaired_text(image.attributes); !repaired.empty()) print_warning(repaired);
    if (image.partitions.empty()) return exit_holds;
    auto results = display::check_declared_splits(*file);
    if (!results) return report_error(results.error());
    return print_results_of_new(*results, image) ? exit_holds : exit_does_not_hold;
}

}  // namespace raylex::experiments
