#include "experiments/study/plan/plan.h"

#include <algorithm>
#include <set>

#include "display/services/hash64.h"
#include "experiments/program/console.h"
#include "experiments/study/plan/shell_places.h"

namespace raylex::experiments {
namespace {

/// Returns a text for file names; other characters become '_'.
std::string file_text(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const bool fits = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                          c == '_' || c == '.';
        result += fits ? c : '_';
    }
    return result.substr(0, 40);
}

std::string run_id(const StudyRun& run) {
    std::string id = run.scene + "." + run.method;
    for (const auto& [key, value] : run.settings) id += "." + file_text(key) + "=" + file_text(value);
    return id + "." + budget_text(run.budget_kind, run.budget) + ".r" + std::to_string(run.replicate);
}

/// Returns a text of everything that distinguishes the cell.
std::string identity(const StudyRun& run) {
    std::string text = run.scene + "\n" + run.method;
    for (const auto& [key, value] : run.settings) text += "\n" + key + "=" + value;
    return text + "\n" + budget_kind_name(run.budget_kind) + " " + number_text(run.budget, 17) + "\n" +
           std::to_string(run.replicate);
}

bool matches(const Exclusion& exclusion, const StudyRun& run) {
    if (!exclusion.scene.empty() && exclusion.scene != run.scene) return false;
    if (!exclusion.method.empty() && exclusion.method != run.method) return false;
    if (exclusion.kind && *exclusion.kind != run.budget_kind) return false;
    if (!exclusion.budgets.empty() &&
        std::find(exclusion.budgets.begin(), exclusion.budgets.end(), run.budget) == exclusion.budgets.end())
        return false;
    return std::all_of(exclusion.settings.begin(), exclusion.settings.end(), [&](const auto& wanted) {
        return std::any_of(run.settings.begin(), run.settings.end(), [&](const auto& setting) {
            return setting.first == wanted.first &&
                   std::find(wanted.second.begin(), wanted.second.end(), setting.second) != wanted.second.end();
        });
    });
}

/// Makes seeds that are unique in the plan, also in their short form.
class SeedSource {
  public:
    explicit SeedSource(std::uint64_t config_seed) : config_seed_(config_seed) {}
    std::uint64_t next(const std::string& purpose, const std::string& what) {
        for (unsigned attempt = 0;; ++attempt) {
            const std::uint64_t seed = seed_for(config_seed_, purpose, what, attempt);
            if (taken_.insert(short_seed(seed)).second) return seed;
        }
    }

  private:
    std::uint64_t config_seed_;
    std::set<std::uint32_t> taken_;
};

/// Returns why a command cannot have this budget; empty if it can.
std::string refusal(const MethodRequest& method, BudgetKind kind) {
    if (method.command.empty()) return {};
    if (kind == BudgetKind::error) return "an external command cannot stop at an error";
    const std::string place = kind == BudgetKind::samples ? "spp" : "seconds";
    return has_place(method.command, place) ? std::string() : "its command has no {" + place + "}";
}

}  // namespace

std::uint64_t seed_for(std::uint64_t config_seed, const std::string& purpose, const std::string& what,
                       unsigned attempt) {
    return hash64(purpose + "\n" + what + "\n" + std::to_string(attempt), config_seed) >> 1;
}

std::uint32_t short_seed(std::uint64_t seed) {
    return static_cast<std::uint32_t>(seed & 0x7FFFFFFFU);
}

std::string budget_text(BudgetKind kind, double budget) {
    const std::string number = number_text(budget, 10);
    if (kind == BudgetKind::samples) return number + "spp";
    return kind == BudgetKind::seconds ? number + "s" : "e" + number;
}

Result<Plan> make_plan(const ExperimentConfig& config) {
    constexpr std::size_t most_cells = 1'000'000;
    Plan plan;
    SeedSource seeds(config.seed);
    // References come first, so that their seeds do not depend on the cells.
    for (const SceneRequest& scene : config.scenes) plan.reference_seeds.push_back(seeds.next("reference", scene.name));
    std::vector<std::size_t> excluded(config.exclusions.size());
    std::set<std::string> ids;
    for (const MethodRequest& method : config.methods)
        for (const BudgetKind kind : {BudgetKind::samples, BudgetKind::seconds, BudgetKind::error}) {
            const bool asked = std::any_of(config.budgets.begin(), config.budgets.end(),
                                           [&](const Budget& each) { return each.kind == kind; });
            if (const std::string why = refusal(method, kind); asked && !why.empty())
                plan.notes.push_back("method '" + method.name + "' has no cells with budgets of " +
                                     budget_kind_name(kind) + ": " + why);
        }
    for (unsigned replicate = 0; replicate < config.replicates; ++replicate)
        for (std::size_t scene = 0; scene < config.scenes.size(); ++scene)
            for (const Budget& budget : config.budgets)
                for (std::size_t variant = 0; variant < config.variants.size(); ++variant) {
                    if (!config.variants[variant].planned) continue;
                    const MethodRequest& method = config.methods[config.variants[variant].method];
                    PlannedRun planned{{}, scene, variant};
                    StudyRun& run = planned.run;
                    run.scene = config.scenes[scene].name;
                    run.method = method.name;
                    run.settings = config.variants[variant].settings;
                    run.budget_kind = budget.kind;
                    run.budget = budget.value;
                    run.replicate = replicate;
                    bool left_out = !refusal(method, budget.kind).empty();
                    for (std::size_t i = 0; i < config.exclusions.size(); ++i)
                        if (matches(config.exclusions[i], run)) {
                            ++excluded[i];
                            left_out = true;
                        }
                    if (left_out) continue;
                    run.id = run_id(run);
                    if (!ids.insert(run.id).second) {
                        run.id += "." + hash_text(hash64(identity(run))).substr(0, 8);
                        ids.insert(run.id);
                    }
                    run.seed = seeds.next("cell", identity(run));
                    plan.runs.push_back(std::move(planned));
                    if (plan.runs.size() > most_cells)
                        return error_at(budget.location,
                                        "the plan has more than 1000000 cells; expected fewer values, methods or "
                                        "replicates");
                }
    for (std::size_t i = 0; i < excluded.size(); ++i)
        if (excluded[i] == 0)
            return error_at(config.exclusions[i].location,
                            "this [[exclude]] matches no cell; expected values that the plan has");
    if (plan.runs.empty()) return error_at({config.file, 1, 1}, "every cell is excluded; expected at least one");
    return plan;
}

}  // namespace raylex::experiments
