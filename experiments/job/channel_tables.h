// Reads the TOML tables about channels: [channels], [[channel]], [[partition]], [macros], [lobe_slots]. A job has other
// tables too; a channel file has only these.
#pragma once

#include "experiments/job/job.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {

/// Reads the tables into the job's fields of the same names. Errors go to the table's source.
void read_channel_tables(TomlTable& root, Job& job);

/// Reads these tables from a channel file, or from a whole job, whose other tables are ignored. Errors as for
/// parse_job().
Result<Job> parse_channel_tables(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
