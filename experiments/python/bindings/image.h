// An image for Python: every layer is an array, whether the image was rendered or read from a file.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "display/output/denoise/denoised_image.h"
#include "display/output/reader/exr_reader.h"
#include "experiments/python/bindings/bindings.h"
#include "lpe/result.h"

namespace raylex::python {

/// The values of a layer in NumPy's order, pixel by pixel.
struct LayerArray {
    std::string name;                     ///< "beauty", "alpha", "direct", "Nn", "z"
    std::size_t layer = 0;                ///< index in the file's layers
    std::vector<std::size_t> planes;      ///< indices of planes of that layer
    std::vector<std::string> components;  ///< names of the planes: R G B, X Y Z, Z
    std::vector<float> values;            ///< [(y * width + x) * components + c], from the top
};

class Image {
  public:
    /// Moves the planes of `image` into arrays.
    explicit Image(display::ExrImage image);

    [[nodiscard]] int width() const { return description_.width; }
    [[nodiscard]] int height() const { return description_.height; }
    [[nodiscard]] const std::string& path() const { return description_.path; }
    [[nodiscard]] const display::ExrImage& description() const { return description_; }  ///< without pixels
    [[nodiscard]] const std::vector<LayerArray>& arrays() const { return arrays_; }
    /// Returns an array by its name, or by any name that ExrImage::require_layer accepts. Errors: those of
    /// require_layer.
    [[nodiscard]] const LayerArray& array(const std::string& name) const;
    /// Returns the array of a layer in the description: its colour, if coverage is separate.
    [[nodiscard]] const LayerArray& array(const display::ImageLayer& layer) const;
    [[nodiscard]] bool contains(const std::string& name) const;
    [[nodiscard]] std::vector<std::string> names() const;

    /// Returns the image for the program's functions, with a copy of the pixels.
    [[nodiscard]] display::ExrImage as_exr() const;

    /// Writes the image like `raylex render`. Only for images rendered by this process.
    std::function<Status(const std::string& path)> write;

    // Results of a render; empty for images from files.
    std::vector<std::string> warnings;
    std::map<std::string, double> statistics;  ///< samples_per_pixel, render_seconds, camera_rays ...
    bool complete = true;

  private:
    void add(std::size_t layer, std::string name, std::vector<std::size_t> planes);
    display::ExrImage description_;
    std::vector<LayerArray> arrays_;
};

/// Returns the image with denoised layers. Errors: those of denoise_image().
std::shared_ptr<Image> denoised(const Image& image, const display::DenoiseOptions& options);

}  // namespace raylex::python
