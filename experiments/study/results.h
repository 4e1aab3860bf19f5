// The files of an experiment as values: the contract between the runner, which writes them, and all readers (merge,
// replay, analysis, reports, and other programs; experiments/docs/studies/results.md describes the files).
//
// Arrays are .npy files with float64 or uint64 in C order, for numpy.load. All light is scene-linear, in the rendering
// space of the scene.
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

/// Names and values in order: settings of a method or a cell, provenance.
using NamedValues = std::vector<std::pair<std::string, std::string>>;

/// An array with values[(y * width + x) * components + c]; y points down from the top.
struct PixelArray {
    std::size_t height = 0, width = 0, components = 0;
    std::vector<double> values;
};

/// Reads an array of two or three dimensions: float64, float32, integers of 8 to 64 bits or bool, in this machine's
/// byte order and C order. Integers beyond 2^53 are rounded. Errors: a missing file, another format, a length that
/// differs from the header.
Result<PixelArray> read_npy(const std::string& path);
/// Writes float64 values of shape (height, width, components). Replaces the file atomically.
Status write_npy(const std::string& path, const PixelArray& array, display::FileSync sync = display::FileSync::now);
/// Writes uint64 values of shape (height, width).
Status write_npy_counts(const std::string& path, std::size_t height, std::size_t width,
                        const std::vector<std::uint64_t>& counts, display::FileSync sync = display::FileSync::now);

enum class BudgetKind : std::uint8_t { samples, seconds, error };
/// Returns "samples", "seconds" or "error".
std::string budget_kind_name(BudgetKind kind);

/// A step of a cell or reference with its times. CPU seconds are those of all threads, or of the child process.
struct Phase {
    std::string name;
    double wall_seconds = 0, cpu_seconds = 0;
};

/// The result of a partition's check in the cell's image file.
struct PartitionResult {
    std::string partition;
    bool holds = false;
    double worst_relative_error = 0;  ///< largest |sum - whole| relative to the bound's (sum of |layers| + |whole|)
};

/// The record of a written file, which reveals damage.
struct FileRecord {
    std::string name;  ///< name in its directory
    std::uint64_t bytes = 0;
    std::string hash;  ///< XXH64 of the content, 16 hexadecimal digits
};

/// Paths that a method is known not to find, as a light path expression.
struct OmittedPathsInfo {
    std::string expression, dialect;
};

/// What a pass of a method rendered; its light is in pass_NAME.mean.npy.
struct PassResult {
    std::string name, method;
    double samples_per_pixel = 0, cpu_seconds = 0;
};

/// One render: a scene, a method with settings, a budget and a unique seed.
struct StudyRun {
    std::string id;  ///< SCENE.METHOD[.KEY=VALUE...].BUDGET.rREPLICATE; unique, valid as a file name
    std::string scene, method;
    NamedValues settings;  ///< swept keys with their values; equal for all cells of a variant
    BudgetKind budget_kind = BudgetKind::samples;
    double budget = 0;       ///< samples per pixel, seconds, or relative error
    unsigned replicate = 0;  ///< from 0
    std::uint64_t seed = 0;
    bool failed = false;
    std::string failure;                  ///< the reason of a failure
    std::uint64_t samples_per_pixel = 0;  ///< reached; for adaptive sampling the rounded mean
    std::uint32_t guide_samples = 0;      ///< of each pixel, from which a guide learned; 0: no guide was used
    /// The time for equal-time comparisons: the integrator's preparation and rendering, or the whole external process.
    /// Loading the scene and building its tables, equal for all methods of raylex, are separate phases and not
    /// included.
    double wall_seconds = 0, cpu_seconds = 0;
    [[nodiscard]] double seconds(bool cpu_clock) const { return cpu_clock ? cpu_seconds : wall_seconds; }
    std::vector<Phase> phases;  ///< load, plan, build, prepare, render, write; for external renderers: process
    std::uint64_t rays = 0, invalid_samples = 0, peak_memory_bytes = 0;  ///< 0 if unknown (external renderers)
    std::vector<PartitionResult> splits;
    std::string part_of;                             ///< the cell of which this is a part; empty: a whole cell
    std::uint64_t first_sample = 0, end_sample = 0;  ///< of a part: its samples of each pixel; the end is exclusive
    unsigned parts = 0;  ///< of a whole cell: number of parts it was merged from; times are sums
    std::string isa;     ///< instruction set of the ray tracer; empty for external renderers
    unsigned threads = 0;
    std::string machine;  ///< processor model and hardware threads; for merged parts one line per machine
    /// Fraction of all processors' time that other processes used during the render; negative: unknown. For merged
    /// parts the largest.
    double other_load = -1;
    std::vector<std::string> warnings;
    std::vector<OmittedPathsInfo> omits;  ///< paths of this scene that the integrator declares not to find
    std::vector<PassResult> passes;       ///< of a method with several passes
    std::vector<FileRecord> files;        ///< all files of the directory except cell.json; empty after a failure
    std::string directory;                ///< directory of its files; empty after a failure
};

struct ChannelInfo {
    std::string name, expression, dialect;
    bool beauty = false;
};

struct SceneInfo {
    std::string name, file, hash;  ///< absolute path; hash of everything in the scene that can change an image
    int width = 0, height = 0;
    std::vector<ChannelInfo> channels;  ///< channels of light; the beauty first
    std::string reference;              ///< directory of the reference; empty: none, or not made yet
    /// standard error of the mean pixel, relative to the image's root mean square; negative: unknown (an imported
    /// image)
    double reference_relative_error = 0;
    std::string reference_method;         ///< name of the method, or file of an imported image
    std::uint64_t reference_samples = 0;  ///< per pixel; 0: unknown
    std::string reference_failure;        ///< why a requested reference is missing
};

struct MethodInfo {
    std::string name, integrator, command;  ///< `command` is empty for methods of raylex
    bool unbiased = true;                   ///< as declared in the config
    NamedValues settings;
};

/// A region in which errors are measured besides the whole image.
struct Region {
    std::string name, scene;    ///< scene "": all
    std::array<int, 4> crop{};  ///< x0, y0, x1, y1; the last two are exclusive; all 0: no crop
    std::string mask_file;      ///< an image whose non-zero pixels count; empty: none
};

struct PartitionInfo {
    std::string name, of;  ///< `of` is "beauty" or the channel that is split
    std::vector<std::string> channels;
};

/// Wall seconds of the run so far, over all sessions.
struct RunnerTime {
    double total = 0;       ///< from the first cell's warm-up to the last cell's last file
    double render = 0;      ///< in renderers, for cells: loading, building, preparing, rendering
    double warm_up = 0;     ///< discarded renders that warm up the machine and measure its speed
    double references = 0;  ///< making references, including rendering
    [[nodiscard]] double overhead() const { return total - render - warm_up - references; }
    /// Overhead relative to the time in renderers, without warm-up and references; 0 without render time.
    [[nodiscard]] double overhead_percent() const { return render > 0 ? 100 * overhead() / render : 0; }
};

struct Experiment {
    std::string name, directory, config_text, config_hash;
    std::string config_file;             ///< file of the text; paths in it are relative to its folder
    std::vector<std::string> overrides;  ///< KEY=VALUE of the command line, in order
    NamedValues provenance;
    bool cpu_clock = false;  ///< methods are compared by CPU seconds of all threads instead of wall seconds
    std::vector<SceneInfo> scenes;
    std::vector<MethodInfo> methods;
    std::vector<Region> regions;
    std::vector<PartitionInfo> partitions;
    std::vector<StudyRun> runs;        ///< finished and failed, in the order of the plan
    std::vector<std::string> missing;  ///< ids of planned cells without a result
    std::vector<StudyRun> parts;       ///< parts of cells, finished and failed, by name, for merge
    std::vector<StudyRun> planned;     ///< all planned cells, without results
    RunnerTime time;

    /// Returns a warning about other processes that used the machine during renders; empty if it was idle or if this is
    /// unknown.
    [[nodiscard]] std::string load_warning() const;
};

/// Reads experiment.json and every cell.json, but no images. Errors: not a results directory, an unsupported version,
/// damage. Directories of references and cells are relative to the current folder.
Result<Experiment> read_experiment(const std::string& directory);

/// Reads CHANNEL.mean.npy of a cell or reference: the filtered mean of the pixels, (height, width, 3).
Result<PixelArray> read_mean(const std::string& directory, const std::string& channel);
/// Reads CHANNEL.m2.npy: the estimated variance of a pixel's mean times n (n - 1), with n samples in the pixel; the sum
/// of squared deviations if all filter weights are equal. Error: the method stores no statistics (splats, external
/// renderers).
Result<PixelArray> read_m2(const std::string& directory, const std::string& channel);
/// Reads samples.npy: (height, width, 1).
Result<PixelArray> read_samples(const std::string& directory);

}  // namespace raylex::experiments
