// A pattern: two textures by turns along u, as a colour or a number texture.
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

class Stripes final : public Pattern {
  public:
    Stripes(TextureId first, TextureId second, float count) : first_(first), second_(second), count_(count) {}
    [[nodiscard]] Rgb rgb(const PatternPoint& point) const override { return point.rgb(chosen(point)); }
    [[nodiscard]] float real(const PatternPoint& point) const override { return point.real(chosen(point)); }

  private:
    [[nodiscard]] TextureId chosen(const PatternPoint& point) const {
        const float place = point.at.u * count_;
        return place - std::floor(place) < 0.5f ? first_ : second_;
    }
    TextureId first_, second_;
    float count_;
};

Result<std::unique_ptr<Pattern>> make_stripes(PatternReader& reader) {
    const TextureId first = reader.input("tex1", 1), second = reader.input("tex2", 0);
    const int count = reader.integer("count", 8, 1, 10000);
    return std::unique_ptr<Pattern>(std::make_unique<Stripes>(first, second, static_cast<float>(count)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_pattern({"stripes",
                      "two textures by turns along u",
                      {{"tex1", ParameterType::texture, "1", "of the first half of each stripe"},
                       {"tex2", ParameterType::texture, "0", "of the second"},
                       {"count", ParameterType::integer, "8", "stripes over u from 0 to 1; 1 to 10000"}},
                      make_stripes});
}
