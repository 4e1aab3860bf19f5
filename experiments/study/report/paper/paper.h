// Parts of a study for a paper besides the plots: LaTeX tables, and crops of images with frames.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns a tabular that needs only \\usepackage{booktabs}, with a row per variant of a scene: error at the largest
/// budget with its interval, its time, the time to an error of 1 % and the speed-up, for one channel on the whole
/// image.
std::string latex_table(const Study& study, const std::string& scene, const std::string& channel);
/// Returns text that LaTeX prints literally.
std::string latex_text(const std::string& text);

/// A rectangle of an image, in pixels.
struct InsetBox {
    int x = 0, y = 0, width = 0, height = 0;
};
/// Returns at most four rectangular regions of the study. For a scene without any, returns the two squares, with a
/// fifth of the shorter side, where the variants' beauties have the largest relative difference from the reference.
std::vector<InsetBox> inset_boxes(const Study& study, std::size_t scene);

/// Writes into an existing folder, for every scene: the beauty of every image on the page with the frames of its
/// insets, every magnified inset with its frame (PNG, sRGB curve), and SCENE.svg with the reference and the insets side
/// by side, with names and errors. Returns the number of files. Unreadable images are left out; the page names them.
Result<std::size_t> write_insets(const Study& study, const std::string& folder);

}  // namespace raylex::experiments
