// @NAME@: a pattern that alternates two textures along u, as a colour or number texture. It writes the index of the
// texture that the camera sees to a display channel.
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

class Stripes final : public Pattern {
  public:
    Stripes(TextureId first, TextureId second, float count) : first_(first), second_(second), count_(count) {}
    [[nodiscard]] transport::Rgb rgb(const PatternPoint& point) const override { return point.rgb(chosen(point)); }
    [[nodiscard]] Real real(const PatternPoint& point) const override { return point.real(chosen(point)); }

  private:
    [[nodiscard]] TextureId chosen(const PatternPoint& point) const {
        const float place = to_float(point.at.u) * count_;
        const bool first = place - std::floor(place) < 0.5f;
        // Every vertex of a camera path can write; depth 0 is the vertex that the camera sees.
        if (const VertexServices& services = point.services(); services.camera_sees())
            services.display->write(stripe_.id(services.display->get_display_channels()), services.row,
                                    first ? 1.0f : 2.0f);
        return first ? first_ : second_;
    }
    TextureId first_, second_;
    float count_;
    display::NamedChannel stripe_{"@NAME@_stripe"};
};

Result<std::unique_ptr<Pattern>> make(PatternReader& reader) {
    const TextureId first = reader.input("tex1", 1), second = reader.input("tex2", 0);
    const int count = reader.integer("count", 8, 1, 10000);
    return std::unique_ptr<Pattern>(std::make_unique<Stripes>(first, second, static_cast<float>(count)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_pattern({"@NAME@",
                      "alternates two textures along u",
                      {{"tex1", ParameterType::texture, "1", "texture of the first half of each stripe"},
                       {"tex2", ParameterType::texture, "0", "texture of the second half"},
                       {"count", ParameterType::integer, "8", "number of stripes over u from 0 to 1; 1 to 10000"}},
                      make});
    host.add_channel(display::declared_channel("@NAME@_stripe", display::ChannelType::real), "1 in tex1, 2 in tex2");
}
