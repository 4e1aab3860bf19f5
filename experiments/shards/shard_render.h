// A render of some of an image's samples: which they are, and the record that their sums become.
//
// Shards are ranges of samples, not tiles: light that lands anywhere, and layers that look at whole samples, stay
// valid. Each is made of whole blocks of the frame buffer's canonical summation, so that sums of shards are, bit for
// bit, those of the whole (Law 3).
#pragma once

#include <cstdint>
#include <string>

#include "experiments/job/job.h"
#include "experiments/job/text/json.h"
#include "experiments/shards/recorded_image.h"
#include "lpe/result.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Samples [first, end) of the `total` that each pixel has.
struct ShardRange {
    std::uint64_t first = 0, end = 0, total = 0;
};

/// The samples of the part-th of `parts` shards, from 1, of about as many blocks each. An Error when there are fewer
/// blocks than shards.
Result<ShardRange> shard_range(unsigned part, unsigned parts, std::uint64_t total);

/// "OUT.exr.shard-2-of-4".
std::string shard_file(const std::string& output, unsigned part, unsigned parts);

/// What a process holds while it renders the shard of that record.
std::string shard_lock(const std::string& record);

/// Samples per pixel of the whole image: as the job says, else as the scene does.
Result<std::uint64_t> samples_of_job(const Job& job, const transport::SceneDescription& scene);

/// Why a job cannot be rendered in shards, by name; success when it can.
Status check_shardable(const Job& job, const transport::SceneDescription& scene);

/// The shard that a job asks for.
class ShardRender {
  public:
    /// Sets the job's first and last sample, and has it go on from the checkpoint that is there.
    static Result<ShardRender> make(Job& job, const transport::SceneDescription& scene);

    /// Whether the record is there already. A damaged one is not, and `warning` says so; one of another render is an
    /// Error that names the difference.
    Result<bool> is_done(const transport::RenderPlan& plan, std::string& warning);

    /// Writes the record to `path`, after is_done().
    Status write(const std::string& path, const transport::RenderOutput& output,
                 const display::ImageDescription& description, const std::vector<ObjectRequest>& filters) const;

    [[nodiscard]] const std::string& record() const { return request_.record; }
    [[nodiscard]] const ShardRange& range() const { return range_; }
    /// "shard 2/4, samples 16 to 31 of 64".
    [[nodiscard]] std::string text() const;

  private:
    ShardRequest request_;
    std::string atlas_;  ///< beside the record; empty: none
    ShardRange range_;
    display::RecordIdentity identity_;
};

/// What a shard's record says beside its image: member "shard" of the JSON.
struct ShardFacts {
    unsigned part = 1, parts = 1;
    bool has_atlas = false;  ///< render wrote one beside the record, before it
    ShardRange range;
    std::uint64_t camera_samples = 0, invalid_samples = 0;
    double wall_seconds = 0, cpu_seconds = 0;
};
/// Throws std::exception where the JSON has no such member.
ShardFacts shard_facts(const Json& json);

}  // namespace raylex::experiments
