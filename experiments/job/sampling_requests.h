// Requests of a job about the number of samples, the end of a render and checkpoints.
#pragma once

#include <string>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;

/// Parses a duration from 0.01 s to 30 days: "60s", "1.5m", "2h" or plain seconds. `what` names it in the Error.
Result<double> parse_interval(const std::string& text, const SourceLocation& where,
                              const std::string& what = "time between checkpoints");

/// Parses a relative error above 0: "1%" or "0.01".
Result<double> parse_tolerance(const std::string& text, const SourceLocation& where);

/// Reads the table [adaptive] of a job. Call it after reading [render].
void read_adaptive(TomlTable& root, Job& job);
/// Returns the job's bucket settings and creates them if necessary.
transport::BucketSettings& bucket_settings(Job& job);

/// Sets the maximum number of samples per pixel of adaptive sampling.
void apply_sample_limit(std::uint64_t samples_per_pixel, display::AdaptiveSettings& adaptive);

/// Returns the checkpoint file of a render: beside its image, or beside the record of its shard. For a render in
/// buckets it is a folder.
std::string checkpoint_file(const Job& job);
/// Sets RenderSettings::checkpoint from the job's interval, which renders in buckets do not need.
void request_checkpoints(Job& job);

/// Checks --guide-only. Errors: there is no guide file, or the job has a request that only a render can fulfil.
/// A job may name a file for statistics; it is not written.
Status check_guide_only(const Job& job);

/// Checks a job before the render. Errors: an unfinished render's checkpoint would be lost, --resume has no checkpoint,
/// or the job has outputs that a checkpoint cannot hold.
Status check_recovery(const Job& job);

}  // namespace raylex::experiments
