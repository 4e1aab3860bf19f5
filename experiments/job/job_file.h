// Reads a TOML job: all that the flags of `raylex render` can say, and labels and light groups for an unmodified scene.
// experiments/docs/rendering/jobs.md lists every key.
#pragma once

#include <string>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Paths in the file are taken relative to it. An unknown key, a wrong type or a value out of range is an Error with
/// line and column. The job's plugins are loaded, so that what they bring can be named. Names that only a scene can
/// judge (labels, materials) are not looked at here.
Result<Job> read_job(const std::string& path);

/// The same for text in memory; `path` serves for messages and as the base of relative paths.
Result<Job> parse_job(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
