// The statistics of a render as an HTML table.
#pragma once

#include <string>

namespace raylex::experiments {

/// From the text of a --stats file; empty when it is none.
std::string statistics_table(const std::string& record);

}  // namespace raylex::experiments
