// Writes a map of errors as a picture, and as numbers for other tools.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "display/output/color/color_manager.h"
#include "display/output/color/color_scale.h"
#include "display/output/comparison/comparison.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

namespace {

constexpr ScaleAnchor scale[] = {{0.00, 0.00, 0.00, 0.00}, {0.20, 0.26, 0.02, -0.13}, {0.45, 0.46, 0.15, -0.10},
                                 {0.65, 0.60, 0.18, 0.07}, {0.82, 0.76, 0.08, 0.14},  {1.00, 0.97, -0.03, 0.08}};

/// An image of which each channel is computed from the index of a pixel's component.
class MapImage final : public PixelImage {
  public:
    using Value = std::function<double(ChannelId, std::size_t)>;
    MapImage(int width, int height, std::vector<ChannelDefinition> channels, Value value)
        : channels_(std::move(channels)), value_(std::move(value)) {
        layout_.width = width;
        layout_.height = height;
    }
    [[nodiscard]] const FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override {
        const int components = component_count(channels_[static_cast<std::size_t>(id)].type);
        std::vector<double> values;
        for (int y = region.y0; y < region.y1; ++y) {
            const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * layout_.width;
            for (std::ptrdiff_t i = (row + region.x0) * components; i < (row + region.x1) * components; ++i)
                values.push_back(value_(id, static_cast<std::size_t>(i)));
        }
        return values;
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override {
        return std::vector<double>(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()),
                                   1.0);
    }

  private:
    FrameBufferLayout layout_;
    std::vector<ChannelDefinition> channels_;
    Value value_;
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
    ChannelDefinition channel;
    channel.name = "error";
    channel.type = ChannelType::real;
    channel.miss_value = INFINITY;  // keeps infinite errors in the file
    const MapImage image(width, height, {channel}, [&map](ChannelId, std::size_t i) { return map[i]; });
    return write_exr(path, image, invalid_channel, description);
}

Status write_unassigned_exr(const std::string& path, const SplitResult& result, const ExrImage& image) {
    ImageDescription description;
    description.chromaticities = image.chromaticities.value_or(Chromaticities{});
    std::vector<ChannelDefinition> channels(2);
    channels[0].name = "unassigned";
    channels[1].name = "counted_twice";
    const auto value = [&light = result.rebuild.light](ChannelId id, std::size_t i) {
        return std::max(0.0, static_cast<double>(id == 0 ? light[i] : -light[i]));
    };
    return write_exr(path, MapImage(image.width, image.height, std::move(channels), value), invalid_channel,
                     description);
}

}  // namespace raylex::display
