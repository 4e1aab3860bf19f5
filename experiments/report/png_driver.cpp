#include "experiments/report/png_driver.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"
#include "display/output/color/color_names.h"
#include "display/output/writer/memory_image.h"
#include "experiments/report/preview.h"

namespace raylex::experiments {
namespace {

class PngDriver : public display::DisplayDriver {
  public:
    PngDriver(std::string file, std::string layer, PictureOptions options, const display::ColorManager& color,
              SourceLocation where)
        : file_(std::move(file)),
          layer_(std::move(layer)),
          options_(std::move(options)),
          color_(color),
          where_(std::move(where)) {}

    Status open(const display::DriverImage& image) override {
        if (Status writable = display::check_writable(file_); !writable) return writable;
        std::vector<std::string> names{"beauty"};
        for (const display::DriverLayer& each : image.layers) names.push_back(each.name);
        // The layers of cryptomattes are not known before the image is finished.
        if (layer_.empty() || layer_.starts_with("Crypto") ||
            std::find(names.begin(), names.end(), layer_) != names.end())
            return success();
        std::string list;
        for (const std::string& each : names)
            if (!each.empty()) list += (list.empty() ? "" : ", ") + each;
        return error_at(where_, "unknown layer '" + layer_ + "'; expected one of: " + list, near_miss(layer_, names));
    }

    Status close(const display::FinishedImage& finished) override {
        auto image = display::image_in_memory(finished.frame_buffer, finished.beauty, finished.description, layer_);
        if (!image) return image.error();
        auto picture = picture_of(*image, image->layers.front(), color_, options_);
        if (!picture) return picture.error();
        return display::write_png(file_, picture->width, picture->height, picture->rgb);
    }
    [[nodiscard]] std::string file() const override { return file_; }

  private:
    std::string file_, layer_;
    PictureOptions options_;
    const display::ColorManager& color_;
    SourceLocation where_;
};

Result<std::unique_ptr<display::DisplayDriver>> make_png(const ParameterSet& set,
                                                         const display::DriverContext& context) {
    auto file = set.string_or("file", "");
    auto layer = set.string_or("layer", "");
    auto display = set.string_or("display", "");
    // The job's view is a view of the job's display, so another display takes its own default.
    auto view = set.string_or("view", display.ok() && !display->empty() ? std::string() : context.view);
    auto exposure = set.real_or("exposure", context.exposure);
    auto size = set.integer_or("size", 0);
    for (const Result<std::string>* each : {&file, &layer, &display, &view})
        if (!*each) return each->error();
    if (!exposure) return exposure.error();
    if (!size) return size.error();
    if (std::filesystem::path(*file).extension() != ".png")
        return error_at(set.location,
                        "the preview '" + *file + "' has no name ending in .png; expected a PNG file name");
    if (*size < 0 || *size > 65536)
        return error_at(set.location, "'size' is " + std::to_string(*size) + " pixels; expected 1 to 65536, or 0");
    if (context.color == nullptr)
        return error_at(set.location, "a preview needs a colour config; expected one in $OCIO or --ocio");
    PictureOptions options{static_cast<int>(*size), *exposure, display->empty() ? context.display : *display, *view};
    if (Status known = display::check_view(*context.color, options.display, options.view); !known)
        return error_at(set.location, known.error().message, known.error().hint);
    return std::unique_ptr<display::DisplayDriver>(
        std::make_unique<PngDriver>(*file, *layer == "beauty" ? "" : *layer, options, *context.color, set.location));
}

}  // namespace

void register_png_driver() {
    if (display::display_driver_registry().find("png") != nullptr) return;  // a plugin may have added it
    display::display_driver_registry().add(
        {"png",
         "one layer as a picture, through the colour config's display and view",
         {{"file", ParameterType::string, "", "the file's name"},
          {"layer", ParameterType::string, "beauty", "which layer"},
          {"display", ParameterType::string, "the job's", "display of the colour config"},
          {"view", ParameterType::string, "the job's", "view of that display"},
          {"exposure", ParameterType::real, "the job's", "stops, for light"},
          {"size", ParameterType::integer, "0", "longest side in pixels; 0 = as rendered"}},
         make_png});
}

}  // namespace raylex::experiments
