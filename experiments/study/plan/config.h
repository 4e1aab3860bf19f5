// The config of an experiment. experiments/docs/studies/config.md lists every key.
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
    Job job;                     ///< only file, resolution, labels and light groups
    std::string reference_file;  ///< an image as reference; empty: [reference] describes how to render one
    SourceLocation location;
};

struct SweepAxis {
    std::string key;  ///< dotted: "max_depth", "integrator.strategy"
    std::vector<AxisValue> values;
    SourceLocation location;
};

struct MethodRequest {
    std::string name, command;  ///< `command` is empty for methods of raylex
    bool unbiased = true;
    double timeout = 0;                  ///< maximum seconds of a cell, which fails after it; 0: none
    transport::RenderSettings settings;  ///< settings of the method's table, without sweeps
    transport::EffectChoices effects;    ///< effects of the method's table
    std::vector<PassRequest> passes;     ///< their samples are those for each sample of the budget
    std::vector<SweepAxis> sweep;        ///< axes from [sweep] and the method's [method.sweep]
    SourceLocation location;
};

/// A method with one value for each of its axes.
struct Variant {
    std::size_t method = 0;  ///< index in ExperimentConfig::methods
    NamedValues settings;    ///< axis -> value
    transport::RenderSettings render;
    transport::EffectChoices effects;
    std::vector<PassRequest> passes{};
    bool planned = true;  ///< false: used only for references
};

struct Budget {
    BudgetKind kind = BudgetKind::samples;
    double value = 0;
    SourceLocation location;
};

struct ReferenceRequest {
    std::string method;         ///< empty: no references are made
    std::size_t variant = 0;    ///< index in ExperimentConfig::variants: the method without sweeps
    std::uint64_t samples = 0;  ///< maximum; 0: only `error` limits
    double error = 0;           ///< 0: only `samples` limits
    double timeout = 0;         ///< seconds; 0: none
    std::string cache;          ///< folder; empty: references/ in the results
    SourceLocation location;
};

/// Excludes cells that match all of its fields.
struct Exclusion {
    std::string scene, method;  ///< empty: any
    std::optional<BudgetKind> kind;
    std::vector<double> budgets;  ///< of this kind; empty: any
    std::vector<std::pair<std::string, std::vector<std::string>>> settings;
    SourceLocation location;
};

struct ExperimentConfig {
    std::string file, text;
    std::vector<std::string> overrides;
    std::string hash;  ///< of the config's values, overrides included, independent of its layout
    std::string name;
    std::uint64_t seed = 0;
    unsigned replicates = 1;
    double checkpoint_seconds = 0;  ///< within cells and references; 0: none
    bool cpu_clock = false;         ///< as in Experiment
    double timeout = 0;             ///< of cells whose method has none, and of loading a scene; 0: none
    Job base;                       ///< settings of all renders: plugins, colour, channels, threads, instruction set
    std::vector<SceneRequest> scenes;
    std::vector<MethodRequest> methods;
    std::vector<Variant> variants;  ///< of all methods in order, then that of references
    std::vector<Budget> budgets;
    ReferenceRequest reference;
    std::vector<Region> regions;
    std::vector<Exclusion> exclusions;

    /// Returns the job of a scene and variant: everything except samples, seed and files.
    [[nodiscard]] Job job(std::size_t scene, const Variant& variant) const;
};

/// Reads and checks a config and loads its plugins. Errors name file, line and column, or the --set: unknown keys with
/// the closest match, empty sweeps, unknown scenes, methods, channels or masks, invalid budgets.
Result<ExperimentConfig> read_experiment_config(const std::string& path, const std::vector<std::string>& overrides);

}  // namespace raylex::experiments
