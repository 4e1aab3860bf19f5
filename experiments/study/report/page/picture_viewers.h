// The viewers of a study's images: their HTML and the data that bench.js reads.
#pragma once

#include <string>

#include "experiments/job/text/json.h"
#include "experiments/study/report/page/pictures.h"

namespace raylex::experiments {

/// One viewer per scene, and what was left out.
std::string image_viewers(const Pictures& pictures);
/// The study's regions stand as insets in the viewers.
Json picture_index(const Study& study, const Pictures& pictures);

}  // namespace raylex::experiments
