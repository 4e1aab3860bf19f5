#include "experiments/cli/judge.h"

#include <filesystem>
#include <string_view>

#include "display/output/atomic_file.h"
#include "display/output/splits/stored_precision.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/tint.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

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

const char* answer_text(const display::SplitVerdict& verdict) {
    switch (verdict.answer) {
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

std::string reasons(const display::SplitVerdict& verdict) {
    std::string text;
    for (const std::string& reason : verdict.allowed_for) text += (text.empty() ? "" : ", ") + reason;
    return text;
}

// Returns what the check allowed beyond rounding and how many pixels need it; empty if it allowed nothing.
std::string allowance_text(const display::SplitVerdict& verdict) {
    if (verdict.allowed_for.empty() || verdict.answer == display::SplitAnswer::holds_to_rounding) return {};
    std::string text = "\n  allowed on top: ";
    if (verdict.allowance.absolute > 0) text += "absolute " + number_text(verdict.allowance.absolute) + ", ";
    if (verdict.allowance.relative > 0) text += "relative " + number_text(verdict.allowance.relative) + ", ";
    text += "for " + reasons(verdict);
    if (verdict.past_rounding > 0)
        text += "; " + std::to_string(verdict.past_rounding) +
                (verdict.past_rounding == 1 ? " pixel needs it" : " pixels need it");
    return text;
}

fs::path residual_map_beside(const display::SplitVerdict& verdict, const display::ExrImage& image) {
    const fs::path source(image.path);
    return source.parent_path() /
           (source.stem().string() + "." + (verdict.partition.empty() ? "sum" : verdict.partition) + ".residual.png");
}

std::string clamped_text(const display::SplitVerdict& verdict) {
    return counted(verdict.clamped, "pixel") +
           " with values clamped to the largest half or float, which are lower bounds: " +
           std::to_string(verdict.judged()) + " of " + counted(verdict.pixels, "pixel") + " judged";
}

}  // namespace

std::string clamped_text(std::size_t pixels, const std::string& what) {
    return counted(pixels, "pixel") +
           " with values clamped to the largest half or float; for them the file does not show whether " + what;
}

std::string verdict_text(const display::SplitVerdict& verdict, const std::string& title) {
    std::string text = (title.empty() ? partition_name(verdict) : title) + ": " + layer_count(verdict) + " against " +
                       target_name(verdict) + ": " + answer_text(verdict);
    text += "\n  largest absolute error " + number_text(verdict.largest_absolute, 6) + " at pixel " +
            pixel_text(verdict.absolute_x, verdict.absolute_y);
    text += "\n  largest relative error " + number_text(verdict.largest_relative, 6) + " at pixel " +
            pixel_text(verdict.relative_x, verdict.relative_y) + "; bound " + number_text(verdict.bound, 6) + " (" +
            verdict.bound_reason + ")";
    text += allowance_text(verdict);
    if (verdict.exceeding > 0)
        text += "\n  " + std::to_string(verdict.exceeding) +
                (verdict.exceeding == 1 ? " pixel exceeds " : " pixels exceed ") +
                (verdict.allowed_for.empty() ? "the bound" : "what is allowed") +
                (verdict.never_above ? "; the sum is never larger than the beauty, so light is missing from the layers"
                                     : "");
    if (const display::NegativeValues& negative = verdict.negative; negative.pixels > 0)
        text += "\n  " + std::to_string(negative.pixels) + (negative.pixels == 1 ? " pixel has" : " pixels have") +
                " negative values, the lowest " + number_text(static_cast<double>(negative.lowest)) + " in " +
                (negative.layer.empty() ? "beauty" : negative.layer) + " at pixel " +
                pixel_text(negative.x, negative.y);
    if (verdict.non_finite > 0)
        text += "\n  " + std::to_string(verdict.non_finite) +
                (verdict.non_finite == 1 ? " pixel holds" : " pixels hold") +
                " values that are not finite, the first " + pixel_text(verdict.non_finite_x, verdict.non_finite_y) +
                (verdict.non_finite_layer.empty() ? std::string() : " in " + verdict.non_finite_layer);
    if (verdict.clamped > 0) text += "\n  " + clamped_text(verdict);
    if (!verdict.holds)
        for (const std::string& lossy : verdict.unexplained)
            text +=
                "\n  " + lossy + " compression loses bits, and no tolerance covers that; --tolerance ABS,REL sets one";
    return text;
}

std::string verdict_line(const display::SplitVerdict& verdict) {
    if (verdict.answer == display::SplitAnswer::cannot_tell)
        return partition_name(verdict) + ": " + answer_text(verdict) + "; " + clamped_text(verdict);
    return partition_name(verdict) + ": " + layer_count(verdict) +
           (verdict.holds ? (verdict.layers.size() == 1 ? " sums to " : " sum to ") : " DO NOT SUM to ") +
           target_name(verdict) +
           (verdict.answer == display::SplitAnswer::holds_as_allowed ? " within what is allowed for " + reasons(verdict)
                                                                     : std::string()) +
           " (largest relative error " + number_text(verdict.largest_relative) + ", bound " +
           number_text(verdict.bound) + ")" + (verdict.clamped > 0 ? "; " + clamped_text(verdict) : std::string());
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

std::string write_residual_map(const display::SplitVerdict& verdict, const display::ExrImage& image) {
    if (verdict.residual.empty()) return "no residual map: the image has no pixels";
    const fs::path beside = residual_map_beside(verdict, image);
    std::string reason;
    for (const fs::path& path : {beside, beside.filename()}) {
        Status written = display::write_residual_png(path.string(), verdict, image.width, image.height);
        if (written)
            return "residual map: " + path.string() + " (blue to violet within the bound, red to yellow above it)";
        reason = written.error().message;
    }
    return "no residual map: " + reason;
}

bool print_verdicts_of_new(std::span<const display::SplitVerdict> verdicts, const display::ExrImage& image) {
    bool hold = true;
    for (const display::SplitVerdict& verdict : verdicts) {
        print_verdict(verdict_line(verdict), verdict.holds);
        hold = hold && verdict.holds;
        const std::string map = residual_map_beside(verdict, image).string();
        if (verdict.answer == display::SplitAnswer::does_not_hold)
            print_line("  " + write_residual_map(verdict, image));
        else if (Status removed = display::remove_file(map); !removed) print_warning(removed.error().to_string());
    }
    return hold;
}

std::string atlas_line(const display::AtlasVerdict& verdict, std::uint64_t pixels) {
    std::string line = "atlas: " + std::to_string(verdict.words) + " path strings, " +
                       number_text(static_cast<double>(verdict.samples) / static_cast<double>(pixels), 3) +
                       " a pixel and at most " + std::to_string(verdict.most_samples) +
                       (verdict.holds ? ", sum to the beauty" : ", DO NOT SUM to the beauty") + " (largest error " +
                       number_text(verdict.largest) + " of the sum of magnitudes)";
    if (verdict.exceeding > 0) line += "; " + std::to_string(verdict.exceeding) + " pixels exceed the bound 2^-23";
    if (verdict.clamped > 0) line += "; " + clamped_text(verdict.clamped, "path strings sum to it");
    return line;
}

int judge_atlas(display::AtlasFile& file) {
    file.read_parts(false);
    auto verdict = display::check_atlas(file, display::light_magnitude_of(file.description().attributes));
    if (!verdict) return report_error(verdict.error());
    const auto pixels = static_cast<std::uint64_t>(file.width()) * static_cast<std::uint64_t>(file.height());
    print_verdict(file.path() + ": " + atlas_line(*verdict, pixels), verdict->holds);
    return verdict->holds ? exit_holds : exit_does_not_hold;
}

}  // namespace raylex::experiments
