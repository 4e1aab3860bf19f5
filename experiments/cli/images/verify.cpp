// raylex verify: checks that the layers of an image sum to the layer that they split.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>

#include "display/output/reader/exr_layers.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/verify/presets.h"

namespace raylex::experiments {
namespace {

struct VerifyOptions {
    std::vector<std::string> files, sums;
    std::string of;
    std::optional<std::string> preset, tolerance_text;
    std::optional<display::Allowance> tolerance;
};

/// Prints the result of a check and writes a heat map if it fails. Returns whether the check holds.
bool print_split_result(const display::SplitResult& result, const display::ExrImage& image,
                        const std::string& title = {}) {
    print_line(image.path + ": " + result_text(result, title));
    if (result.answer == display::SplitAnswer::does_not_hold) print_line("  " + write_residual_map(result, image));
    return result.holds;
}

void note_incomplete(const display::ExrImage& image) {
    if (image.attributes.contains("raylex/incomplete"))
        print_line(image.path + ": the render was interrupted; this image is incomplete");
    if (const std::string repaired = repaired_text(image.attributes); !repaired.empty())
        print_warning(image.path + ": " + repaired);
}

// Parses "ABS,REL", two numbers that are not negative.
Result<display::Allowance> parse_tolerance(const std::string& text) {
    display::Allowance allowance;
    allowance.instead_of_compression = true;
    allowance.reason = "--tolerance";
    const char* at = text.c_str();
    for (double* number : {&allowance.absolute, &allowance.relative}) {
        char* end = nullptr;
        *number = std::strtod(at, &end);
        const bool last = number == &allowance.relative;
        if (end == at || !std::isfinite(*number) || *number < 0 || *end != (last ? '\0' : ',')) {
            Error error =
                error_at({"--tolerance", 0, static_cast<int>(at - text.c_str()) + 1},
                         "expected ABS,REL: two non-negative numbers, such as 1e-6,1e-5 (|sum - of| <= rounding + "
                         "ABS + REL (sum of |terms| + |of|))");
            error.excerpt = text;
            return error;
        }
        at = end + 1;
    }
    return allowance;
}

/// Checks the splits of an image in memory, or of a file that is read in bands.
template <class Source>
int verify_sum_of(const Source& source, const display::ExrImage& image, const VerifyOptions& options) {
    auto result =
        display::check_split(source, options.of, options.sums, options.tolerance.value_or(display::Allowance{}));
    if (!result) return report_error(result.error());
    note_incomplete(image);
    return print_split_result(*result, image) ? exit_holds : exit_does_not_hold;
}

int verify_sum(const VerifyOptions& options) {
    if (options.files.size() == 1) {
        auto file = display::ExrBands::open(options.files.front());
        return file ? verify_sum_of(*file, file->image(), options) : report_error(file.error());
    }
    auto image = display::read_exr_set(options.files);
    return image ? verify_sum_of(*image, *image, options) : report_error(image.error());
}

// Checks all splits of an image that a preset found. Returns whether all hold, or an error.
Result<bool> verify_found(const display::ExrImage& image, const Preset& preset, const std::vector<FoundSplit>& splits,
                          const VerifyOptions& options) {
    bool all_hold = true;
    note_incomplete(image);
    for (const FoundSplit& split : splits) {
        auto result = check_found(image, split, options.tolerance);
        if (!result) return std::move(result).error();
        const bool holds = print_split_result(*result, image, std::string(preset.renderer) + " " + split.title);
        print_line("  " + result->of + " = " + split.formula);
        if (!split.note.empty()) print_line("  " + split.note);
        all_hold = all_hold && holds;
        if (holds) continue;
        std::string missing;
        for (const std::string& pass : split.missing) missing += (missing.empty() ? "" : ", ") + pass;
        if (!missing.empty()) print_line("  missing from the file and the sum: " + missing);
        print_line("  " + std::string(preset.advice));
    }
    return all_hold;
}

int verify_preset(const VerifyOptions& options) {
    auto preset = find_preset(*options.preset);
    if (!preset) return report_error(preset.error());
    // Several files are separate images, unless the first has nothing to check: then they are the layers of one image.
    auto first = display::read_exr(options.files.front());
    if (!first) return report_error(first.error());
    const bool one_image = options.files.size() > 1 && !find_splits(**preset, *first, options.of);
    bool all_hold = true;
    for (const std::string& file : options.files) {
        const bool is_first = &file == &options.files.front();
        auto image = one_image  ? display::read_exr_set(options.files)
                     : is_first ? std::move(first)  // NOLINT(bugprone-use-after-move): the loop comes to it once
                                : display::read_exr(file);
        if (!image) return report_error(image.error());
        auto splits = find_splits(**preset, *image, options.of);
        if (!splits) return report_error(splits.error());
        auto hold = verify_found(*image, **preset, *splits, options);
        if (!hold) return report_error(hold.error());
        all_hold = *hold && all_hold;
        if (one_image) break;
    }
    return all_hold ? exit_holds : exit_does_not_hold;
}

/// Returns the names of the first layers of light besides the beauty, as an example of a sum.
std::string some_layers(const display::ExrImage& image) {
    constexpr int most = 3;
    std::string list;
    int count = 0;
    const display::ImageLayer* beauty = image.layer("");
    for (const display::ImageLayer& layer : image.layers) {
        if (&layer == beauty || !layer.is_color() || layer.name.empty() || count == most) continue;
        list += (count++ == 0 ? "" : ",") + layer.name;
    }
    return list.empty() ? "diffuse_*,specular_*,emission" : list + ",...";
}

std::string without_partition(const display::ExrImage& image) {
    std::string text = image.path + ": the header declares no partition, so there is nothing to check. ";
    const std::string command = "raylex verify " + shell_command({image.path});
    for (const Preset& preset : presets())
        if (is_named_after(preset, image))
            text += "The names of its layers are those of " + std::string(preset.renderer) + ": " + command +
                    " --preset " + preset.name + ". ";
    return text + "Name the layers that must sum to another: " + command + " --of beauty --sum " +
           shell_command({some_layers(image)}) + ". The layers are: " + display::list_names(image.layer_names());
}

int verify_declared(const VerifyOptions& options) {
    bool all_hold = true;
    std::string without;
    for (const std::string& file : options.files) {
        if (display::is_atlas(file)) {
            auto atlas = display::AtlasFile::open(file);
            if (!atlas) return report_error(atlas.error());
            const int code = report_atlas_check(**atlas);
            if (code == exit_bad_input) return code;
            all_hold = code == exit_holds && all_hold;
            continue;
        }
        auto bands = display::ExrBands::open(file);
        if (!bands) return report_error(bands.error());
        const display::ExrImage& image = bands->image();
        if (image.partitions.empty()) {
            if (without.empty()) without = without_partition(image);
            continue;
        }
        auto results = display::check_declared_splits(*bands, options.tolerance.value_or(display::Allowance{}));
        if (!results) return report_error(results.error());
        note_incomplete(image);
        for (const display::SplitResult& result : *results) all_hold = print_split_result(result, image) && all_hold;
    }
    if (!without.empty()) return report_error(without);
    return all_hold ? exit_holds : exit_does_not_hold;
}

int verify(VerifyOptions options) {
    if (!options.of.empty() && options.sums.empty() && !options.preset)
        return report_error("--of " + options.of +
                            " needs --sum with the layers that must sum to it, such as --sum 'diffuse_*,emission'");
    if (!options.sums.empty() && options.preset)
        return report_error("--sum and --preset both choose the layers; expected one of them");
    if (options.tolerance_text) {
        auto tolerance = parse_tolerance(*options.tolerance_text);
        if (!tolerance) return report_error(tolerance.error());
        options.tolerance = std::move(*tolerance);
    }
    return options.preset         ? verify_preset(options)
           : options.sums.empty() ? verify_declared(options)
                                  : verify_sum(options);
}

std::string preset_help() {
    std::string names;
    for (const Preset& preset : presets()) names += (names.empty() ? "" : ", ") + std::string(preset.name);
    return "finds the layers by the names that a renderer uses, and checks every split: " + names;
}

}  // namespace

void add_verify_command(CLI::App& app, CommandContext& context) {
    CLI::App* command =
        app.add_subcommand("verify", "Checks in every pixel that layers of an image sum to the layer that they split.");
    auto options = std::make_shared<VerifyOptions>();
    command
        ->add_option("FILE.exr", options->files,
                     "images of any renderer; with --sum, several files are the layers of one image")
        ->required()
        ->option_text("...");
    command->add_option("--preset", options->preset, preset_help())->option_text("NAME");
    command->add_option("--of", options->of, "the layer that the others must sum to; default with --sum: beauty")
        ->option_text("LAYER");
    command
        ->add_option(
            "--sum", options->sums,
            "the layers that must sum to it, separated by commas: names, patterns with * and ?, and expressions with + "
            "- * ( ); 'DiffDir' also finds 'ViewLayer.DiffDir' if that is the only such layer")
        ->option_text("'SUM,...'")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        ->add_option("--tolerance", options->tolerance_text,
                     "allows |sum - of| <= rounding + ABS + REL (sum of |terms| + |of|), instead of the tolerance of a "
                     "preset or of lossy compression")
        ->option_text("ABS,REL");
    command->footer(
        "Without --sum and --preset, every partition in the header is checked; in a path atlas, the path strings must "
        "sum to "
        "the\nbeauty. Results: holds to rounding, holds within what is allowed, does not hold, cannot tell (every "
        "pixel is clamped\nto the largest number of its type).\n"
        "The rounding bound is the precision of the stored type (float 2^-23, half 2^-10) times the sum of |terms| + "
        "|of|,\nthrough products too, and 2^-24 for each operation of another renderer. Larger errors are allowed for "
        "DWA compression,\nfor a preset's measured accumulation, and by --tolerance. A failed check writes a residual "
        "heat map beside the image.\n"
        "Example: raylex verify their.exr --of Combined --sum '(DiffDir+DiffInd)*DiffCol, "
        "(GlossDir+GlossInd)*GlossCol, Emit'\n"
        "Exit codes: 0 holds, 1 does not hold, or cannot tell, 2 bad usage or input.");
    command->callback([options, &context] { context.exit_code = verify(*options); });
}

}  // namespace raylex::experiments
