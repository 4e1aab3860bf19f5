// The page of a study.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/pictures.h"

namespace raylex::experiments {

/// Returns one self-contained HTML file. `d3` is the text of the library.
std::string study_page(const Study& study, const std::vector<Plot>& plots, const Pictures& pictures,
                       const std::string& d3);

}  // namespace raylex::experiments
