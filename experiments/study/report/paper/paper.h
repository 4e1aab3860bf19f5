// What of a study goes into a paper, beside the plots: tables for LaTeX, and crops of its images with frames.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A tabular for \usepackage{booktabs} and nothing else: a row per variant of a scene; error at the largest budget with
/// its interval, what it took, the time to an error of 1 % and the speed-up, for one channel on the whole image.
std::string latex_table(const Study& study, const std::string& scene, const std::string& channel);
/// Text that LaTeX prints as it stands.
std::string latex_text(const std::string& text);

/// A rectangle of an image, in pixels.
struct InsetBox {
    int x = 0, y = 0, width = 0, height = 0;
};
/// The study's regions that are rectangles, at most four; of a scene without any the two squares of a fifth of its
/// shorter side where its variants' beauties are furthest from the reference, relative to it.
std::vector<InsetBox> inset_boxes(const Study& study, std::size_t scene);

/// Writes, into a folder that is there, for every scene the beauty of every image that the page shows, with the frames
/// of its insets, and every inset magnified with its frame (PNG, sRGB curve), and SCENE.svg: reference and insets
/// beside each other with names and errors. Returns how many files. Images that cannot be read are left out; the page
/// names them.
Result<std::size_t> write_insets(const Study& study, const std::string& folder);

}  // namespace raylex::experiments
