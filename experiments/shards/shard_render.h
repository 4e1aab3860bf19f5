// Renders a part of an image's samples and writes their sums to a record.
//
// Shards are ranges of samples, not tiles, so light that can land in any pixel, and layers of whole samples, stay
// valid. A shard consists of whole blocks of the frame buffer's canonical summation, so the sums over shards are
// bit-identical to a single render (Law 3).
#pragma once

#include <cstdint>
#include <string>

#include "experiments/job/job.h"
#include "experiments/job/text/json.h"
#include "experiments/shards/recorded_image.h"
#include "lpe/result.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// The samples [first, end) of the `total` samples of each pixel.
struct ShardRange {
    std::uint64_t first = 0, end = 0, total = 0;
};

/// Returns the samples of shard `part` (from 1) of `parts`; shards differ by at most one block. Returns an Error if
/// there are fewer blocks than shards.
Result<ShardRange> shard_range(unsigned part, unsigned parts, std::uint64_t total);

/// Returns the file name of a shard's record: "OUT.exr.shard-2-of-4".
std::string shard_file(const std::string& output, unsigned part, unsigned parts);

/// Returns the lock file that a process holds while it renders the shard of that record.
std::string shard_lock(const std::string& record);

/// Returns the number of samples per pixel of the whole image: the job's, otherwise the scene's.
Result<std::uint64_t> samples_of_job(const Job& job, const transport::SceneDescription& scene);

/// Returns an error with the reason why a job cannot be rendered in shards, or success.
Status check_shardable(const Job& job, const transport::SceneDescription& scene);

/// The shard of a job with --shard.
class ShardRender {
  public:
    /// Sets the job's first and last sample, and resumes an existing checkpoint.
    static Result<ShardRender> make(Job& job, const transport::SceneDescription& scene);

    /// Returns whether the record exists. A damaged record counts as missing and sets `warning`. A record of another
    /// render is an Error that names the difference.
    Result<bool> is_done(const transport::RenderPlan& plan, std::string& warning);

    /// Writes the record to `path`. Call it after is_done().
    Status write(const std::string& path, const transport::RenderOutput& output,
                 const display::ImageDescription& description, const std::vector<ObjectRequest>& filters) const;

    [[nodiscard]] const std::string& record() const { return request_.record; }
    [[nodiscard]] const ShardRange& range() const { return range_; }
    /// Returns a description: "shard 2/4, samples 16 to 31 of 64".
    [[nodiscard]] std::string text() const;

  private:
    ShardRequest request_;
    std::string atlas_;  ///< atlas file beside the record; empty: none
    ShardRange range_;
    display::RecordIdentity identity_;
};

/// Facts in a shard's record besides the image: member "shard" of the JSON.
struct ShardFacts {
    unsigned part = 1, parts = 1;
    bool has_atlas = false;  ///< an atlas is beside the record, written before it
    ShardRange range;
    std::uint64_t camera_samples = 0, invalid_samples = 0;
    double wall_seconds = 0, cpu_seconds = 0;
    std::uint64_t guide_samples = 0;  ///< of each pixel, from which the guide of all shards learned
    double guide_cpu_seconds = 0;     ///< of the training; 0 in a shard that read its guide from a file
};
/// Parses the facts. Throws std::exception if the JSON has no such member.
ShardFacts shard_facts(const Json& json);

}  // namespace raylex::experiments
