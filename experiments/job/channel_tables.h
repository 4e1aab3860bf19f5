// The tables of a TOML file that speak of channels: [channels], [[channel]], [[partition]], [macros], [lobe_slots]. A
// job has them among others; a file of channels has nothing else.
#pragma once

#include "experiments/job/job.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {

/// Reads them into the job's fields of the same names. Errors go to the table's source.
void read_channel_tables(TomlTable& root, Job& job);

/// A file of channels: these tables alone, or a whole job, of which only they count. Errors as parse_job's.
Result<Job> parse_channel_tables(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
