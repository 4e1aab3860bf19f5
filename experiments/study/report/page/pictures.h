// Images small enough for a page, at half precision, for the viewer in study_page.js.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// Where the image that stands for a variant on a scene lies: the first replicate of its largest budget.
struct PictureSource {
    std::size_t scene = 0;
    std::string directory, variant, name;  ///< no variant: the reference
};
/// Scenes in order, of each the variants in order and then the reference, as far as there are images.
std::vector<PictureSource> picture_sources(const Study& study);

/// A variant's image (or the reference) on a scene: one picture per channel.
struct PictureSet {
    std::string name;                             ///< "path, 1024 samples", "reference"
    std::vector<std::optional<std::size_t>> ids;  ///< none where the image has no such channel (external renderers)
};

struct ScenePictures {
    std::string scene;
    int width = 0, height = 0;  ///< of the pictures
    int block = 1;              ///< pixels of the image per pixel of a picture, along each side
    std::vector<std::string> channels;
    std::vector<PictureSet> images;  ///< variants in order, the reference last
};

struct Pictures {
    std::vector<ScenePictures> scenes;
    std::vector<std::string> encoded;  ///< by id: base64
    std::size_t bytes = 0;
    std::vector<std::string> left_out;  ///< images of which no channel could be read: why
};

/// The first replicate of every variant's largest budget. All pictures are reduced by one whole factor until they fit
/// in `picture_bytes` together.
Pictures pictures_of(const Study& study);

/// pack_halves of the components one after the other.
std::string encode_picture(const PixelArray& image);
/// Means over blocks of pixels.
PixelArray reduced(const PixelArray& image, std::size_t block);

}  // namespace raylex::experiments
