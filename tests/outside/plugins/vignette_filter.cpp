// A display filter: the corners of the image darken, as behind a lens. It sees resolved pixels; beauty and every light
// path expression get the same factor at a pixel, so splits still sum to beauty (Law 1).
#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::display;

class Vignette final : public DisplayFilter {
  public:
    Vignette(double strength, std::vector<ChannelId> light) : strength_(strength), light_(std::move(light)) {}
    bool changes(ChannelId id) const override { return std::find(light_.begin(), light_.end(), id) != light_.end(); }
    void apply(const PixelImage& before, ChannelId, const PixelRegion& region,
               std::span<double> pixels) const override {
        const double half_width = before.layout().width / 2.0, half_height = before.layout().height / 2.0;
        const double corner = half_width * half_width + half_height * half_height;
        for (int y = region.y0, i = 0; y < region.y1; ++y)
            for (int x = region.x0; x < region.x1; ++x) {
                const double from_x = x + 0.5 - half_width, from_y = y + 0.5 - half_height;
                const double factor = 1 - strength_ * (from_x * from_x + from_y * from_y) / corner;
                for (int c = 0; c < 3; ++c) pixels[static_cast<std::size_t>(i++)] *= factor;
            }
    }

  private:
    double strength_;
    std::vector<ChannelId> light_;
};

Result<std::unique_ptr<DisplayFilter>> make_vignette(const ParameterSet& parameters,
                                                     const DisplayFilterContext& context) {
    transport::ParameterReader reader(parameters);
    const float strength = reader.real("strength", 0.5f, 0, 1);
    if (reader.error()) return *reader.error();
    std::vector<ChannelId> light;
    for (std::size_t i = 0; i < context.channels.size(); ++i)
        if (context.channels[i].style == ChannelStyle::expression) light.push_back(static_cast<ChannelId>(i));
    return std::unique_ptr<DisplayFilter>(std::make_unique<Vignette>(static_cast<double>(strength), std::move(light)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_display_filter(
        {"vignette",
         "light falls off towards the corners of the image",
         {{"strength", ParameterType::real, "0.5", "share of the light that the corners lose; 0 to 1"}},
         make_vignette});
}
