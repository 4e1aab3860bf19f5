// Images at half precision, small enough for a page, for the viewer in study_page.js.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// The image shown for a variant on a scene: the first replicate of its largest budget.
struct PictureSource {
    std::size_t scene = 0;
    std::string directory, variant, name;  ///< `variant` is empty for the reference
};
/// Returns the sources by scene; for each scene the variants in order, then the reference, if they have images.
std::vector<PictureSource> picture_sources(const Study& study);

/// The image of a variant (or the reference) on a scene: one picture per channel.
struct PictureSet {
    std::string name;                             ///< "path, 1024 samples", "reference"
    std::vector<std::optional<std::size_t>> ids;  ///< empty if the image lacks the channel (external renderers)
};

struct ScenePictures {
    std::string scene;
    int width = 0, height = 0;  ///< size of the pictures
    int block = 1;              ///< side of the block of image pixels per picture pixel
    std::vector<std::string> channels;
    std::vector<PictureSet> images;  ///< variants in order, then the reference
};

struct Pictures {
    std::vector<ScenePictures> scenes;
    std::vector<std::string> encoded;  ///< by id, in base64
    std::size_t bytes = 0;
    std::vector<std::string> left_out;  ///< images without a readable channel, with the reason
};

/// Makes pictures of the first replicate of every variant's largest budget. All are reduced by one integer factor until
/// they fit in `picture_bytes` together.
Pictures pictures_of(const Study& study);

/// Returns pack_halves() of the components, one after the other.
std::string encode_picture(const PixelArray& image);
/// Returns the means over blocks of pixels.
PixelArray reduced(const PixelArray& image, std::size_t block);

}  // namespace raylex::experiments
