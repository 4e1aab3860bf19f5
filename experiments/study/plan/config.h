// An experiment's config as values. experiments/docs/studies/config.md lists every key.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "experiments/study/plan/axis.h"
#include "experiments/study/plan/config_text.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct SceneRequest {
    std::string name;
    Job job;                     ///< file, resolution, labels and light groups; nothing else
    std::string reference_file;  ///< an image to measure against; empty: [reference] says how one is made
    SourceLocation location;
};

struct SweepAxis {
    std::string key;  ///< dotted: "max_depth", "integrator.strategy"
    std::vector<AxisValue> values;
    SourceLocation location;
};

struct MethodRequest {
    std::string name, command;  ///< `command` is empty for methods of this program
    bool unbiased = true;
    double timeout = 0;                  ///< seconds a cell may take in all, else it is ended and failed; 0 = none
    transport::RenderSettings settings;  ///< what the method's table says, without sweeps
    transport::EffectChoices effects;    ///< the same
    std::vector<SweepAxis> sweep;        ///< [sweep] and the method's own [method.sweep]: the axes that it goes along
    SourceLocation location;
};

/// A method with one value of each of its axes.
struct Variant {
    std::size_t method = 0;  ///< in ExperimentConfig::methods
    NamedValues settings;    ///< axis -> value
    transport::RenderSettings render;
    transport::EffectChoices effects;
    bool planned = true;  ///< false: for references alone
};

struct Budget {
    BudgetKind kind = BudgetKind::samples;
    double value = 0;
    SourceLocation location;
};

struct ReferenceRequest {
    std::string method;         ///< empty: no references are made
    std::size_t variant = 0;    ///< in ExperimentConfig::variants: the method as its table has it, unswept
    std::uint64_t samples = 0;  ///< at most; 0: no limit beside `error`
    double error = 0;           ///< 0: `samples` alone
    double timeout = 0;         ///< seconds; 0 = none
    std::string cache;          ///< folder; empty: references/ in the results
    SourceLocation location;
};

/// Cells that match all that is said are left out.
struct Exclusion {
    std::string scene, method;  ///< empty: any
    std::optional<BudgetKind> kind;
    std::vector<double> budgets;  ///< of that kind; empty: any
    std::vector<std::pair<std::string, std::vector<std::string>>> settings;
    SourceLocation location;
};

struct ExperimentConfig {
    std::string file, text;
    std::vector<std::string> overrides;
    std::string hash;  ///< of what the config says, overrides included, however it is laid out
    std::string name;
    std::uint64_t seed = 0;
    unsigned replicates = 1;
    double checkpoint_seconds = 0;  ///< within cells and references; 0 = none
    bool cpu_clock = false;         ///< as Experiment has it
    double timeout = 0;             ///< of cells whose method has none of its own, and of loading a scene; 0 = none
    Job base;                       ///< plugins, colour, channels, threads, instruction set: what all renders share
    std::vector<SceneRequest> scenes;
    std::vector<MethodRequest> methods;
    std::vector<Variant> variants;  ///< of all methods in turn, then that of references
    std::vector<Budget> budgets;
    ReferenceRequest reference;
    std::vector<Region> regions;
    std::vector<Exclusion> exclusions;

    /// The render of a scene by a variant: everything but samples, seed and files.
    [[nodiscard]] Job job(std::size_t scene, const Variant& variant) const;
};

/// Reads, checks and loads the plugins. Errors name file, line and column, or the --set that they come from: unknown
/// keys with near misses, empty sweeps, scenes, methods, channels or masks that are not there, budgets that cannot be.
Result<ExperimentConfig> read_experiment_config(const std::string& path, const std::vector<std::string>& overrides);

}  // namespace raylex::experiments
