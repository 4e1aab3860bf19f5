#include "transport/textures/procedural_patterns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "display/services/elementary.h"
#include "transport/color/color_space.h"
#include "transport/math/noise.h"
#include "transport/textures/texture_mapping.h"

namespace raylex::transport {
namespace {

/// A pattern with the same formula for colours and numbers.
template <class Formula>
class FormulaPattern : public Pattern {
  public:
    explicit FormulaPattern(Formula formula) : formula_(std::move(formula)) {}
    [[nodiscard]] Rgb rgb(const PatternPoint& point) const override {
        return formula_(point, [&](TextureId input) { return point.rgb(input); });
    }
    [[nodiscard]] Real real(const PatternPoint& point) const override {
        return formula_(point, [&](TextureId input) { return point.real(input); });
    }

  private:
    Formula formula_;
};

template <class Formula>
std::unique_ptr<Pattern> pattern_of(Formula formula) {
    return std::make_unique<FormulaPattern<Formula>>(std::move(formula));
}

/// Blends tex1 and tex2. The weight of tex1 is |cos| between the normal and `dir`, and tex2 has the rest.
Result<std::unique_ptr<Pattern>> make_directionmix(PatternReader& reader) {
    const TextureId one = reader.input("tex1", 0), other = reader.input("tex2", 1);
    const Vec3 written = read_vector(reader, "dir", {0, 1, 0});
    const Vec3 dir = reader.texture.to_world.vector(written);
    if (!(length_squared(dir) > 0) && !reader.error())
        return error_at(reader.texture.location, "directionmix texture '" + reader.texture.name +
                                                     "': 'dir' has no length; expected a direction");
    return pattern_of([one, other, along = normalize(dir)](const PatternPoint& point, const auto& value) {
        const Real amount = abs_dot(point.at.normal, along);
        decltype(value(one)) sum{};
        if (amount != 0) sum += value(one) * amount;
        if (amount != 1) sum += value(other) * (1 - amount);
        return sum;
    });
}

/// Whether a point is in a dot. Half of the unit cells around integers contain a dot of radius 0.35, at a random place.
bool in_dot(const Vec2& st) {
    const Real radius = Real(0.35), shift = Real(0.5) - radius, third = Real(0.5);
    const Real s = std::floor(st.x + Real(0.5)), t = std::floor(st.y + Real(0.5));
    if (!(gradient_noise({s + Real(0.5), t + Real(0.5), third}) > 0)) return false;
    const Real ds = st.x - (s + shift * gradient_noise({s + Real(1.5), t + Real(2.8), third})),
               dt = st.y - (t + shift * gradient_noise({s + Real(4.5), t + Real(9.8), third}));
    return ds * ds + dt * dt < radius * radius;
}

Result<std::unique_ptr<Pattern>> make_dots(PatternReader& reader) {
    // pbrt-v4's renderer (FloatDotsTexture::Create) differs from its documentation: "inside" is the value around the
    // dots.
    const TextureId around = reader.input("inside", 1), dots = reader.input("outside", 0);
    const TextureMapping mapping = read_mapping(reader, reader.texture.to_world);
    return pattern_of([=](const PatternPoint& point, const auto& value) {
        return value(in_dot(mapping.map(point.at)) ? dots : around);
    });
}

/// Blends four corners of the unit square of texture coordinates, and extrapolates linearly beyond it.
Result<std::unique_ptr<Pattern>> make_bilerp(PatternReader& reader) {
    const TextureId v00 = reader.input("v00", 0), v01 = reader.input("v01", 1), v10 = reader.input("v10", 0),
                    v11 = reader.input("v11", 1);
    const TextureMapping mapping = read_mapping(reader, reader.texture.to_world);
    return pattern_of([=](const PatternPoint& point, const auto& value) {
        const Vec2 st = mapping.map(point.at);
        return value(v00) * ((1 - st.x) * (1 - st.y)) + value(v01) * ((1 - st.x) * st.y) +
               value(v10) * (st.x * (1 - st.y)) + value(v11) * (st.x * st.y);
    });
}

Octaves read_octaves(PatternReader& reader) {
    // 64 octaves reach 10^19 times the frequency, beyond the resolution of float.
    return {reader.integer("octaves", 8, 0, 64), reader.real("roughness", Real(0.5))};
}

/// A number for each point of the texture's own space.
template <class Formula>
Result<std::unique_ptr<Pattern>> make_solid_number(PatternReader& reader, const Formula& formula) {
    if (reader.texture.spectrum)
        return error_at(reader.texture.location,
                        "texture '" + reader.texture.name + "' of type " + reader.texture.type +
                            " is a spectrum texture; expected a float texture: pbrt has no "
                            "colours of this type",
                        "a mix texture takes it as its amount between two colours");
    const Transform to_texture = reader.texture.to_world.inverse();
    return pattern_of([=](const PatternPoint& point, const auto& value) -> decltype(value(TextureId{0})) {
        return decltype(value(TextureId{0}))(formula(to_texture.point(point.at.position)));
    });
}

Result<std::unique_ptr<Pattern>> make_fbm(PatternReader& reader) {
    const Octaves octaves = read_octaves(reader);
    return make_solid_number(reader, [octaves](const Vec3& p) { return noise_sum(p, octaves); });
}

Result<std::unique_ptr<Pattern>> make_wrinkled(PatternReader& reader) {
    const Octaves octaves = read_octaves(reader);
    return make_solid_number(reader, [octaves](const Vec3& p) { return absolute_noise_sum(p, octaves); });
}

/// Waves, with the local strength of the wind as height.
Result<std::unique_ptr<Pattern>> make_windy(PatternReader& reader) {
    return make_solid_number(reader, [](const Vec3& p) {
        return std::abs(noise_sum(p * Real(0.1), {3, Real(0.5)})) * noise_sum(p, {6, Real(0.5)});
    });
}

/// The colours of pbrt's marble, linear sRGB times 2/3: a spline of six Bezier segments that share control points.
Triple marble_color(double t) {
    static constexpr std::array<Triple, 9> c{{{0.58, 0.58, 0.6},
                                              {0.58, 0.58, 0.6},
                                              {0.58, 0.58, 0.6},
                                              {0.5, 0.5, 0.5},
                                              {0.6, 0.59, 0.58},
                                              {0.58, 0.58, 0.6},
                                              {0.58, 0.58, 0.6},
                                              {0.2, 0.2, 0.33},
                                              {0.58, 0.58, 0.6}}};
    constexpr int segments = 6;
    const int first = std::clamp(static_cast<int>(t * segments), 0, segments - 1);
    const double u = t * segments - first, v = 1 - u;
    const std::array<double, 4> bernstein{v * v * v, 3 * v * v * u, 3 * v * u * u, u * u * u};
    Triple rgb{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t i = 0; i < 3; ++i) rgb[i] += 1.5 * bernstein[k] * c[static_cast<std::size_t>(first) + k][i];
    return rgb;
}

Result<std::unique_ptr<Pattern>> make_marble(PatternReader& reader) {
    if (!reader.texture.spectrum)
        return error_at(reader.texture.location, "texture '" + reader.texture.name +
                                                     "' of type marble is a float texture; expected a spectrum "
                                                     "texture: marble is coloured");
    const Octaves octaves = read_octaves(reader);
    const Real scale = reader.real("scale", 1), variation = reader.real("variation", Real(0.2));
    const Transform to_texture = reader.texture.to_world.inverse();
    const Matrix3 to_rendering =
        multiply(reader.color.rendering_from_scene, rgb_from_rgb(reader.color.scene_space, ColorSpace::srgb, true));
    return pattern_of([=](const PatternPoint& point, const auto& value) -> decltype(value(TextureId{0})) {
        const Vec3 p = to_texture.point(point.at.position) * scale;
        const Real phase = p.y + variation * noise_sum(p, octaves);
        const double t = 0.5 + 0.5 * elementary::sin(static_cast<double>(std::isfinite(phase) ? phase : 0));
        const Triple c = multiply(to_rendering, marble_color(t));
        const Rgb colour{std::clamp(static_cast<Real>(c[0]), Real(0), Real(1)),
                         std::clamp(static_cast<Real>(c[1]), Real(0), Real(1)),
                         std::clamp(static_cast<Real>(c[2]), Real(0), Real(1))};
        if constexpr (std::is_same_v<decltype(value(TextureId{0})), Rgb>) return colour;
        else return colour.average();
    });
}

}  // namespace

void register_procedural_patterns(Registry<PatternFactory>& registry) {
    using enum ParameterType;
    registry.add({"directionmix",
                  "two textures, blended by the angle between the surface normal and a direction",
                  {{"tex1", texture, "0", "value where the normal is parallel to `dir`"},
                   {"tex2", texture, "1", "value where the normal is perpendicular to `dir`"},
                   {"dir", vector3, "0 1 0", "in the texture's space"}},
                  make_directionmix});
    registry.add({"bilerp", "a blend of four values at the corners of the unit square of texture coordinates",
                  with_mapping({{"v00", texture, "0", "at (0, 0)"},
                                {"v01", texture, "1", "at (0, 1)"},
                                {"v10", texture, "0", "at (1, 0)"},
                                {"v11", texture, "1", "at (1, 1)"}}),
                  make_bilerp});
    registry.add({"dots", "dots of radius 0.35 in half of the cells of a grid, at random",
                  with_mapping({{"inside", texture, "1", "value around the dots (not inside them), as in pbrt-v4"},
                                {"outside", texture, "0", "value of the dots"}}),
                  make_dots});
    const std::vector<ParameterDescription> octaves{
        {"octaves", integer, "8", "number of octaves, each with 1.99 times the frequency"},
        {"roughness", real, "0.5", "height of an octave relative to the previous one"}};
    registry.add({"fbm", "a sum of octaves of noise (float textures)", octaves, make_fbm});
    registry.add({"wrinkled", "a sum of absolute values of noise (float textures)", octaves, make_wrinkled});
    registry.add({"windy", "waves of an uneven wind (float textures)", {}, make_windy});
    std::vector<ParameterDescription> marble = octaves;
    marble.push_back({"scale", real, "1", "scale of the texture's space"});
    marble.push_back({"variation", real, "0.2", "strength of the noise that bends the veins"});
    registry.add({"marble", "veins of marble (spectrum textures)", marble, make_marble});
}

}  // namespace raylex::transport
