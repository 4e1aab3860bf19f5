// Reads a plugin's stamp from its file, without loading it.
#pragma once

#include <string>

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/plugins/plugin_stamp.h"

namespace raylex::transport {

/// Reads the stamp from the ELF file (System V gABI, chapter 4). Errors at `where`: a file that cannot be read, that is
/// not a shared library for this machine, or that contains no stamp of this format.
Result<PluginStamp> read_plugin_stamp(const std::string& file, const SourceLocation& where);

/// Returns success if a plugin with this stamp matches this program; else an Error at `where` that names the
/// difference.
Status check_plugin_stamp(const PluginStamp& stamp, const std::string& file, const SourceLocation& where);

}  // namespace raylex::transport
