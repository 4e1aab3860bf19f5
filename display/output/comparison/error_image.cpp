// Writes a map of errors as a picture, and as numbers for other tools.
#include <algorithm>
#include <cmath>

#include "display/output/color/color_manager.h"
#include "display/output/color/color_scale.h"
#include "display/output/comparison/comparison.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

namespace {

constexpr ScaleAnchor scale[] = {{0.00, 0.00, 0.00, 0.00}, {0.20, 0.26, 0.02, -0.13}, {0.45, 0.46, 0.15, -0.10},
                                 {0.65, 0.60, 0.18, 0.07}, {0.82, 0.76, 0.08, 0.14},  {1.00, 0.97, -0.03, 0.08}};

/// The map as an image with one channel.
class ErrorMap final : public PixelImage {
  public:
    ErrorMap(const std::vector<double>& map, int width, int height) : map_(map) {
        layout_.width = width;
        layout_.height = height;
        channel_.name = "error";
        channel_.type = ChannelType::real;
        channel_.miss_value = INFINITY;  // keeps infinite errors in the file
    }
    [[nodiscard]] const FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return {&channel_, 1}; }
    [[nodiscard]] std::vector<double> resolve(ChannelId, const PixelRegion& region) const override {
        std::vector<double> values;
        for (int y = region.y0; y < region.y1; ++y) {
            const auto row = map_.begin() + static_cast<std::ptrdiff_t>(y) * layout_.width;
            values.insert(values.end(), row + region.x0, row + region.x1);
        }
        return values;
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override {
        return std::vector<double>(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()),
                                   1.0);
    }

  private:
    const std::vector<double>& map_;
    FrameBufferLayout layout_;
    ChannelDefinition channel_;
};

}  // namespace

std::vector<unsigned char> error_colors(const std::vector<double>& map, double most) {
    std::vector<unsigned char> rgb;
    rgb.reserve(map.size() * 3);
    for (const double error : map) {
        const std::array<unsigned char, 3> color = !std::isfinite(error) ? std::array<unsigned char, 3>{0, 255, 255}
                                                   : most > 0 ? scale_color(scale, std::min(error / most, 1.0))
                                                              : std::array<unsigned char, 3>{0, 0, 0};
        rgb.insert(rgb.end(), color.begin(), color.end());
    }
    return rgb;
}

Status write_error_png(const std::string& path, const std::vector<double>& map, int width, int height, double most) {
    return write_png(path, width, height, error_colors(map, most));
}

Status write_error_exr(const std::string& path, const std::vector<double>& map, int width, int height,
                       const std::map<std::string, std::string>& attributes) {
    ImageDescription description;
    description.attributes = attributes;
    return write_exr(path, ErrorMap(map, width, height), invalid_channel, description);
}

}  // namespace raylex::display
