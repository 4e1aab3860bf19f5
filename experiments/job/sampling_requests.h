// What a job says about where samples go, when a render ends and how it survives a crash: [adaptive], [render] time and
// checkpoint, and the texts of --until-error, --time and --checkpoint.
#pragma once

#include <string>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;

/// "60s", "1.5m", "2h" or plain seconds, as seconds from 0.01 to 30 days.
/// `what` it is stands in the Error.
Result<double> parse_interval(const std::string& text, const SourceLocation& where,
                              const std::string& what = "time between checkpoints");

/// "1%" or "0.01", above 0.
Result<double> parse_tolerance(const std::string& text, const SourceLocation& where);

/// The table [adaptive] of a job, after [render].
void read_adaptive(TomlTable& root, Job& job);
/// [render] checkpoint = "60s".
void read_checkpoint(TomlTable& render, Job& job);

/// [render] memory = "2GiB" and bucket_rows = 64.
void read_buckets(TomlTable& render, Job& job);
/// What the job says of buckets, from now on something.
transport::BucketSettings& bucket_settings(Job& job);

/// [render] time = "5m".
void read_time(TomlTable& render, Job& job);
/// Ends the render after so many seconds, unless samples_per_pixel are fewer.
void apply_time_limit(double seconds, Job& job);

/// Puts samples_per_pixel where adaptive sampling looks: it is the most that a pixel may have.
void apply_sample_limit(std::uint64_t samples_per_pixel, display::AdaptiveSettings& adaptive);

/// Where a render of this job is saved: beside its image, or beside the record of its shard. Of a render in buckets, a
/// folder.
std::string checkpoint_file(const Job& job);

/// Before a render: a checkpoint of an unfinished render that would be lost, --resume without one, and what no
/// checkpoint can hold are Errors.
Status check_recovery(const Job& job);

}  // namespace raylex::experiments
