// The statistics of a render as an HTML table.
#pragma once

#include <string>

namespace raylex::experiments {

/// `record`: the text of a --stats file. Empty if the text is something else.
std::string statistics_table(const std::string& record);

}  // namespace raylex::experiments
