// What an experiment leaves on disk, as values: the contract between the runner, which writes it, and everything that
// reads it (merging, replaying, analysis, reports, and programs outside: experiments/docs/studies/results.md describes
// the files).
//
// Arrays are .npy files, float64 and uint64 in C order, so numpy.load opens them. All light is scene-linear, in the
// rendering space of the scene.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "display/output/atomic_file.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Names and values in the order given: settings of a method, of a cell, provenance.
using NamedValues = std::vector<std::pair<std::string, std::string>>;

/// values[(y * width + x) * components + c], y downwards from the top.
struct PixelArray {
    std::size_t height = 0, width = 0, components = 0;
    std::vector<double> values;
};

/// An array of two or three dimensions: float64, float32, signed or unsigned integers of 8 to 64 bits or bool, of this
/// machine's byte order, in C order. Integers beyond 2^53 are rounded. Errors: no such file, another format, a length
/// that is not what the header says.
Result<PixelArray> read_npy(const std::string& path);
/// float64 of shape (height, width, components). Replaces the file whole or not at all.
Status write_npy(const std::string& path, const PixelArray& array, display::FileSync sync = display::FileSync::now);
/// uint64 of shape (height, width).
Status write_npy_counts(const std::string& path, std::size_t height, std::size_t width,
                        const std::vector<std::uint64_t>& counts, display::FileSync sync = display::FileSync::now);

enum class BudgetKind : std::uint8_t { samples, seconds, error };
/// "samples", "seconds" or "error".
std::string budget_kind_name(BudgetKind kind);

/// One step of a cell or reference and what it took. CPU seconds are of all threads, or of the child process.
struct Phase {
    std::string name;
    double wall_seconds = 0, cpu_seconds = 0;
};

/// Whether the layers of a partition sum to what they split, in the cell's image file.
struct PartitionVerdict {
    std::string partition;
    bool holds = false;
    double worst_relative_error = 0;  ///< largest |sum - whole| over the bound's (sum of |layers| + |whole|)
};

/// A file as it was written: what tells damage.
struct FileRecord {
    std::string name;  ///< in its directory
    std::uint64_t bytes = 0;
    std::string hash;  ///< XXH64 of the content, 16 hexadecimal digits
};

/// Paths that a method is known not to find, as a light path expression.
struct OmittedPathsInfo {
    std::string expression, dialect;
};

/// One render: a scene by a method with settings, to a budget, with a seed of its own.
struct Cell {
    std::string id;  ///< SCENE.METHOD[.KEY=VALUE...].BUDGET.rREPLICATE; unique, fit for a file name
    std::string scene, method;
    NamedValues settings;  ///< swept keys and their values here; the same throughout a variant
    BudgetKind budget_kind = BudgetKind::samples;
    double budget = 0;       ///< samples per pixel, seconds, or relative error
    unsigned replicate = 0;  ///< from 0
    std::uint64_t seed = 0;
    bool failed = false;
    std::string failure;                  ///< the reason, when it failed
    std::uint64_t samples_per_pixel = 0;  ///< reached; when adaptive, the mean rounded
    /// What an equal-time claim must count: the integrator's preparation and its rendering, or the whole external
    /// process. Loading the scene and building its tables, the same for all methods of this program, are phases and not
    /// in it.
    double wall_seconds = 0, cpu_seconds = 0;
    [[nodiscard]] double seconds(bool cpu_clock) const { return cpu_clock ? cpu_seconds : wall_seconds; }
    std::vector<Phase> phases;  ///< load, plan, build, prepare, render, write; of external renderers: process
    std::uint64_t rays = 0, invalid_samples = 0, peak_memory_bytes = 0;  ///< 0 where not known (external renderers)
    std::vector<PartitionVerdict> splits;
    std::string part_of;                             ///< the cell that this is a part of; empty: a whole cell
    std::uint64_t first_sample = 0, end_sample = 0;  ///< of a part: its samples of each pixel, the last exclusive
    unsigned parts = 0;  ///< of a whole cell: how many parts it was merged from, whose times are added up
    std::string isa;     ///< instruction set of the ray tracer; empty for external renderers
    unsigned threads = 0;
    std::string machine;  ///< processor model and hardware threads; of a cell of parts each once, a line each
    /// Share of all processors' time that other processes used while it was rendered; negative: not known. Of a cell
    /// of parts the largest.
    double other_load = -1;
    std::vector<std::string> warnings;
    std::vector<OmittedPathsInfo> omits;  ///< what its integrator says it does not find of this scene's light
    std::vector<FileRecord> files;        ///< all of its directory but cell.json; empty when it failed
    std::string directory;                ///< where its files are; empty when it failed
};

struct ChannelInfo {
    std::string name, expression, dialect;
    bool beauty = false;
};

struct SceneInfo {
    std::string name, file, hash;  ///< absolute path; hash of all in the scene that can change an image
    int width = 0, height = 0;
    std::vector<ChannelInfo> channels;    ///< of light; the beauty first
    std::string reference;                ///< its directory; empty: none, or not made yet
    double reference_relative_error = 0;  ///< standard error of the mean pixel, relative to the image's root mean
                                          ///< square; negative: not known (an image from elsewhere)
    std::string reference_method;         ///< method's name, or the file it came from
    std::uint64_t reference_samples = 0;  ///< per pixel; 0: not known
    std::string reference_failure;        ///< why there is none though one was asked for
};

struct MethodInfo {
    std::string name, integrator, command;  ///< `command` is empty for methods of this program
    bool unbiased = true;                   ///< as the config claims
    NamedValues settings;
};

/// Where errors are measured beside the whole image.
struct Region {
    std::string name, scene;    ///< scene "": all
    std::array<int, 4> crop{};  ///< x0, y0, x1, y1; the last two exclusive; all 0: no crop
    std::string mask_file;      ///< an image; pixels where it is not 0 count; empty: none
};

struct PartitionInfo {
    std::string name, of;  ///< `of` "beauty" or the channel it splits
    std::vector<std::string> channels;
};

/// Wall seconds that making the results took so far, over all sessions.
struct RunnerTime {
    double total = 0;       ///< from the first cell's warm-up to the last cell's last file
    double render = 0;      ///< within renderers, for cells: loading, building, preparing, rendering
    double warm_up = 0;     ///< renders that are thrown away, to warm the machine and to learn its speed
    double references = 0;  ///< making references, which is rendering too
    [[nodiscard]] double overhead() const { return total - render - warm_up - references; }
    /// Of the time within renderers, warm-up and references not counted; 0 while there is none.
    [[nodiscard]] double overhead_percent() const { return render > 0 ? 100 * overhead() / render : 0; }
};

struct Experiment {
    std::string name, directory, config_text, config_hash;
    std::string config_file;             ///< where the text came from: paths in it count from its folder
    std::vector<std::string> overrides;  ///< KEY=VALUE of the command line, in order
    NamedValues provenance;
    bool cpu_clock = false;  ///< methods are compared by CPU seconds of all threads, not by wall seconds
    std::vector<SceneInfo> scenes;
    std::vector<MethodInfo> methods;
    std::vector<Region> regions;
    std::vector<PartitionInfo> partitions;
    std::vector<Cell> cells;           ///< done and failed, in the order of the plan
    std::vector<std::string> missing;  ///< ids of planned cells that have no result yet
    std::vector<Cell> parts;           ///< of cells, done and failed, by name: what merge makes cells of
    std::vector<Cell> planned;         ///< all of the plan, as far as a plan says: no results in them
    RunnerTime time;

    /// What other processes used of the machine while cells were rendered; empty where it was idle or is not known.
    [[nodiscard]] std::string load_warning() const;
};

/// Reads experiment.json and every cell's cell.json; no images. Errors: not a results directory, a version that this
/// program does not read, damage. The directories of references and cells count from the current folder.
Result<Experiment> read_experiment(const std::string& directory);

/// CHANNEL.mean.npy of a cell or a reference: filtered mean of the pixels, (height, width, 3).
Result<PixelArray> read_mean(const std::string& directory, const std::string& channel);
/// CHANNEL.m2.npy: with n samples in a pixel, the estimated variance of its mean times n (n - 1): the sum of squared
/// deviations where all filter weights are of one size. An Error where the method keeps no statistics (splats,
/// external).
Result<PixelArray> read_m2(const std::string& directory, const std::string& channel);
/// samples.npy: (height, width, 1).
Result<PixelArray> read_samples(const std::string& directory);

}  // namespace raylex::experiments
