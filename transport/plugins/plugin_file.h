// Reads a plugin's stamp out of its file, without loading it.
#pragma once

#include <string>

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/plugins/plugin_stamp.h"

namespace raylex::transport {

/// The stamp in the ELF file (System V gABI, chapter 4). Errors at `where`: a file that cannot be read, that is no
/// shared library or none for this machine, or that carries no stamp of this form.
Result<PluginStamp> read_plugin_stamp(const std::string& file, const SourceLocation& where);

/// Success when a plugin with this stamp fits this program; else an Error at `where` that says what differs.
Status check_plugin_stamp(const PluginStamp& stamp, const std::string& file, const SourceLocation& where);

}  // namespace raylex::transport
