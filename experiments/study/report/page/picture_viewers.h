// The viewers of a study's images: HTML, and data for bench.js.
#pragma once

#include <string>

#include "experiments/job/text/json.h"
#include "experiments/study/report/page/pictures.h"

namespace raylex::experiments {

/// Returns the HTML of one viewer per scene, and of a list of omissions.
std::string image_viewers(const Pictures& pictures);
/// Returns the data of the viewers. The study's regions appear as insets.
Json picture_index(const Study& study, const Pictures& pictures);

}  // namespace raylex::experiments
