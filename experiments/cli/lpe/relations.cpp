// raylex lpe equal, contains, empty: prove relations between expressions.
#include "lpe/algebra/proofs/relations.h"
#include "experiments/program/exit_codes.h"

#include <memory>

#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

struct RelationOptions {
    DialectOption dialect;
    SceneOption scene;
    lpe::PathStrings words;  // the paths of the scene
    std::string first, second;
};

int result(const Result<lpe::Proof>& proof) {
    if (!proof) return report_error(proof.error());
    return print_result(proof->holds, proof->summary, proof->witness, proof->warnings);
}

int run_equal(const RelationOptions& options) {
    const std::vector<lpe::ChannelSource> both{
        bare_expression(options.first, options.dialect.value(), "", "first expression"),
        bare_expression(options.second, options.dialect.value(), "", "second expression")};
    return result(lpe::check_equal(both, options.words));
}

int run_contains(const RelationOptions& options) {
    return result(lpe::check_contains(bare_expression(options.first, options.dialect.value(), "", "first expression"),
                                      bare_expression(options.second, options.dialect.value(), "", "second expression"),
                                      options.words));
}

int run_empty(const RelationOptions& options) {
    return result(
        lpe::check_empty(bare_expression(options.first, options.dialect.value(), "", "expression"), options.words));
}

void add_relation(CLI::App& lpe, CommandContext& context, const std::string& name, const std::string& description,
                  bool two, const std::string& holds, int (*run)(const RelationOptions&)) {
    auto options = std::make_shared<RelationOptions>();
    CLI::App* command = lpe.add_subcommand(name, description);
    command->add_option(two ? "A" : "EXPR", options->first, "an expression")->required()->option_text("(required)");
    if (two) command->add_option("B", options->second, "another")->required()->option_text("(required)");
    add_scene_option(*command, options->scene);
    add_dialect_option(*command, options->dialect);
    command->footer(
        "The proof covers every path that any scene, or the one of --scene, can produce. Prefixes are ignored, because "
        "they do not change which paths match.\n"
        "Exit codes: 0 " +
        holds + ", 1 not so; the shortest counterexample is printed, 2 bad usage or input.");
    command->callback([options, run, &context] {
        auto scene = options->scene.load();
        if (scene) options->words = path_strings_of(*scene);
        context.exit_code = scene ? run(*options) : report_error(scene.error());
    });
}

}  // namespace

int print_result(bool holds, const std::string& summary, const lpe::Witness& witness,
                 const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) print_warning(warning);
    print_line(summary);
    if (holds) return exit_holds;
    print_line(witness.text);
    return exit_does_not_hold;
}

void add_lpe_relation_commands(CLI::App& lpe, CommandContext& context) {
    add_relation(lpe, context, "equal", "Proves that two expressions match the same paths, whatever their dialects.",
                 true, "equal", run_equal);
    add_relation(lpe, context, "contains", "Proves that the first expression matches every path of the second.", true,
                 "contained", run_contains);
    add_relation(lpe, context, "empty", "Proves that no path matches the expression.", false, "no path matches",
                 run_empty);
}

}  // namespace raylex::experiments
