// An image as Python has it: every layer an array, whether it was rendered or read from a file.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "experiments/python/bindings/bindings.h"
#include "lpe/result.h"

namespace raylex::python {

/// A layer's numbers, pixel by pixel, the way NumPy has them.
struct LayerArray {
    std::string name;                     ///< "beauty", "alpha", "direct", "Nn", "z"
    std::size_t layer = 0;                ///< of the file's layers
    std::vector<std::size_t> planes;      ///< which of that layer's
    std::vector<std::string> components;  ///< their names: R G B, X Y Z, Z
    std::vector<float> values;            ///< [(y * width + x) * components + c], from the top
};

class Image {
  public:
    /// Takes the planes out of `image`: they live on as arrays.
    explicit Image(display::ExrImage image);

    [[nodiscard]] int width() const { return description_.width; }
    [[nodiscard]] int height() const { return description_.height; }
    [[nodiscard]] const std::string& path() const { return description_.path; }
    [[nodiscard]] const display::ExrImage& description() const { return description_; }  ///< without pixels
    [[nodiscard]] const std::vector<LayerArray>& arrays() const { return arrays_; }
    /// By the name of an array, or any that ExrImage::require_layer takes. Errors are those of it.
    [[nodiscard]] const LayerArray& array(const std::string& name) const;
    /// Of a layer of the description: its colour, where coverage is another.
    [[nodiscard]] const LayerArray& array(const display::ImageLayer& layer) const;
    [[nodiscard]] bool contains(const std::string& name) const;
    [[nodiscard]] std::vector<std::string> names() const;

    /// The image as the program's own functions take it: a copy of the pixels.
    [[nodiscard]] display::ExrImage as_exr() const;

    /// Writes it as `raylex render` would. Only of what was rendered here.
    std::function<Status(const std::string& path)> write;

    // What only a render tells.
    std::vector<std::string> warnings;
    std::map<std::string, double> statistics;  ///< samples_per_pixel, render_seconds, camera_rays ...
    bool complete = true;

  private:
    void add(std::size_t layer, std::string name, std::vector<std::size_t> planes);
    display::ExrImage description_;
    std::vector<LayerArray> arrays_;
};

}  // namespace raylex::python
