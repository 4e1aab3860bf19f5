// raylex lpe truth: computes the values of expressions in a closed room, where the light of every path is known.
#include <memory>

#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/truth.h"

namespace raylex::experiments {
namespace {

struct TruthOptions {
    DialectOption dialect;
    std::vector<std::string> expressions;
    double diffuse = 0.5, mirror = 0, sheet = 0, emitted = 1;
    std::vector<double> sheets;
    std::optional<std::uint64_t> max_depth;
    std::string object, group;
    bool by_depth = false;
};

/// Returns the room with the walls and sheets of raylex's materials raylex:diffuse-mirror and raylex:sheet.
lpe::Enclosure enclosure_of(const TruthOptions& options) {
    const lpe::LobeSlots slots;
    const auto lobe = [&](lpe::EventType type, lpe::Scatter scatter, const char* name, double albedo) {
        return lpe::WeightedEvent{{type, scatter, slots.number(scatter, name), {options.object, name}}, albedo};
    };
    lpe::Enclosure enclosure;
    enclosure.scattering = {
        lobe(lpe::EventType::reflection, lpe::Scatter::diffuse, "diffuse", options.diffuse),
        lobe(lpe::EventType::reflection, lpe::Scatter::singular, "mirror", options.mirror),
    };
    const auto sheet = lobe(lpe::EventType::transmission, lpe::Scatter::singular, "sheet", options.sheet);
    if (options.sheets.empty()) enclosure.scattering.push_back(sheet);
    else enclosure.sheets = {sheet, options.sheets};
    enclosure.terminals = {{{lpe::EventType::light, lpe::Scatter::none, 0, {options.group}}, options.emitted}};
    enclosure.max_depth = options.max_depth;
    return enclosure;
}

int run_truth(const TruthOptions& options) {
    const lpe::Enclosure enclosure = enclosure_of(options);
    constexpr int digits = 9;
    const bool several = options.expressions.size() > 1;
    for (const std::string& text : options.expressions) {
        const lpe::ChannelSource source = bare_expression(text, options.dialect.value(), "", "expression");
        const auto truth = lpe::enclosure_truth(source, enclosure);
        if (!truth) return report_error(about_argument(truth.error(), "expression", source.expression));
        print_line(number_text(truth->value, digits) + (several ? "  " + text : ""));
        if (!options.by_depth) continue;
        for (std::size_t depth = 0; depth < truth->by_depth.size(); ++depth)
            print_line("  " + std::to_string(depth) + " scattering: " + number_text(truth->by_depth[depth], digits));
    }
    return exit_holds;
}

}  // namespace

void add_lpe_truth_command(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<TruthOptions>();
    CLI::App* truth = lpe.add_subcommand("truth",
                                         "Computes the value of expressions, the same in every pixel, in any closed "
                                         "room whose walls all emit and scatter "
                                         "alike.");
    truth->add_option("EXPR", options->expressions, "the expressions")->required()->option_text("(required)");
    const auto albedo = [truth](const char* name, double& value, const char* help) {
        truth->add_option(name, value, help)->check(CLI::Range(0.0, 1.0))->capture_default_str();
    };
    albedo("--kd", options->diffuse, "albedo of the walls' Lambert lobe");
    albedo("--ks", options->mirror, "albedo of the walls' ideal mirror");
    albedo("--kt", options->sheet, "fraction that every surface, or only every --sheet, transmits straight (T S)");
    truth
        ->add_option("--sheet", options->sheets,
                     "a sphere that only transmits light, concentric with a spherical room; R is its radius as a "
                     "fraction of the room's; the camera is in the innermost sphere; may be repeated")
        ->option_text("R")
        ->allow_extra_args(false);
    truth->add_option("--le", options->emitted, "radiance emitted by every wall")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    truth->add_option("--max-depth", options->max_depth,
                      "maximum number of scattering events of a path; default: no limit");
    truth->add_option("--object", options->object, "label of all walls");
    truth->add_option("--group", options->group, "light group of all walls");
    truth->add_flag("--by-depth", options->by_depth, "also prints the value of paths with 0 to 8 scattering events");
    add_dialect_option(*truth, options->dialect);
    truth->footer(
        "Radiance in such a room is the same along every ray, and a path carries the product of its albedos. The "
        "value\nis therefore the solution of a linear system over the expression's automaton. Render the room "
        "(material\nraylex:diffuse-mirror, an area light on every wall) with the same expression: a difference larger "
        "than noise\nis a mistake of the renderer or of the expression.\n"
        "Example: raylex lpe truth 'C<RD><RS>+L' --kd .5 --ks .3     gives 0.214285714\n"
        "Exit codes: 0 computed, 2 bad usage or input.");
    truth->callback([options, &context] { context.exit_code = run_truth(*options); });
}

}  // namespace raylex::experiments
