// The data of a texture table: a graph of nodes, each compiled from one texture. Private to transport/textures.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "transport/textures/image_filter.h"
#include "transport/textures/image_sampler.h"
#include "transport/textures/pattern.h"
#include "transport/textures/texture.h"
#include "transport/textures/texture_mapping.h"

namespace raylex::transport {

/// The processing of an image's values after interpolation.
struct ImageStage {
    ImageSampler sampler;
    ImageFilter filter;
    Real scale = 1;
    bool invert = false;
    bool clamp_to_one = false;  ///< albedo
    bool convert = false;       ///< to the rendering space
    std::array<std::array<Real, 3>, 3> matrix{};

    [[nodiscard]] Real real(const Vec2& st, const TexelFootprint* footprint) const {
        const Real value = scale * (footprint == nullptr ? sampler.real(st) : filter.real(sampler, st, *footprint));
        return invert ? std::max(Real(0), 1 - value) : value;
    }
    [[nodiscard]] Rgb rgb(const Vec2& st, const TexelFootprint* footprint) const {
        Rgb c = (footprint == nullptr ? sampler.rgb(st) : filter.rgb(sampler, st, *footprint)) * scale;
        if (invert) c = Rgb(1) - c;
        c = limit(c);
        if (!convert) return c;
        return limit({matrix[0][0] * c.r + matrix[0][1] * c.g + matrix[0][2] * c.b,
                      matrix[1][0] * c.r + matrix[1][1] * c.g + matrix[1][2] * c.b,
                      matrix[2][0] * c.r + matrix[2][1] * c.g + matrix[2][2] * c.b});
    }

  private:
    [[nodiscard]] Rgb limit(const Rgb& c) const {
        const Real top = clamp_to_one ? 1.0f : INFINITY;
        return {std::clamp(c.r, Real(0), top), std::clamp(c.g, Real(0), top), std::clamp(c.b, Real(0), top)};
    }
};

/// A compiled texture: a node of the graph; its children are indices.
struct TextureNode {
    enum class Kind : std::uint8_t { constant, scale, mix, checkerboard, solid_checkerboard, image, pattern };
    Kind kind = Kind::constant;
    Rgb value;                 ///< constant (for a float texture: in all three components)
    TextureId a = 0, b = 0;    ///< scale: a; mix, checkerboards: a and b
    TextureId amount = 0;      ///< scale, mix: a float texture
    std::int32_t mapping = 0;  ///< checkerboard, image
    std::int32_t stage = 0;    ///< image: its stage; pattern: its index
};

/// The maximum cost of one look-up including its inputs. Textures that use another one twice each grow exponentially.
struct LookupCost {
    double work = 1;  ///< number of textures; a double does not overflow
    std::uint64_t depth = 1;

    LookupCost& operator+=(const LookupCost& input) {
        work += input.work;
        depth = std::max(depth, input.depth + 1);
        return *this;
    }
};

inline bool odd(Real x) {
    const Real half = std::floor(x) * 0.5f;
    return half != std::floor(half);
}

/// An image that was read ahead of its first use.
struct ReadImage {
    Result<Image> image = Image{};
    std::optional<std::string> warning;
    std::optional<ImagePyramid> pyramid;  ///< for images that are filtered
};

struct TextureTable::Storage final : TextureLookup {
    std::vector<TextureNode> nodes;
    std::vector<LookupCost> costs;  // parallel to nodes
    std::vector<std::unique_ptr<Pattern>> patterns;
    std::vector<LookupCost> pattern_costs;  // parallel to patterns
    bool looks_ahead = false;               // some pattern uses look_ahead()
    std::vector<TextureMapping> mappings;
    std::vector<ImageStage> stages;
    using ImageKey = std::pair<std::string, std::string>;  // path, encoding
    std::deque<Image> images;                              // a deque keeps addresses valid
    std::map<ImageKey, const Image*> image_by_file;
    std::map<ImageKey, ReadImage> images_ahead;     // removed at their first use
    std::map<const Image*, ImagePyramid> pyramids;  // for images that are filtered

    std::vector<SceneTexture> sources;                                             // to_world leads to render space
    std::map<std::string, std::vector<std::size_t>, std::less<>> sources_by_name;  // ascending
    std::map<std::pair<std::size_t, SpectrumRole>, TextureId> compiled;
    ColorContext color;
    std::string scene_file;
    std::vector<Error> warnings;

    Result<TextureId> reference(const Parameter& parameter, const SourceLocation& where, bool spectrum,
                                SpectrumRole role, std::size_t visible);
    Result<TextureId> rgb_input(const ParameterSet& set, std::string_view name, const Rgb& fallback, SpectrumRole role,
                                std::size_t visible);
    Result<TextureId> real_input(const ParameterSet& set, std::string_view name, Real fallback, std::size_t visible);
    Result<TextureId> compile(std::size_t index, SpectrumRole role);
    Result<TextureNode> compile_node(const SceneTexture& source, SpectrumRole role, std::size_t visible);
    TextureFilter filter_of(const SceneTexture& source, ParameterReader& reader);
    TextureNode scaled_image(const TextureNode& scaled, bool spectrum);
    Result<TextureNode> compile_image(const SceneTexture& source, SpectrumRole role);
    Result<TextureNode> compile_pattern(const SceneTexture& source, const PatternFactory& factory, SpectrumRole role,
                                        std::size_t visible);
    Result<const Image*> load_image(const std::string& name, const std::string& encoding, bool by_file_rules,
                                    const SourceLocation& where);
    [[nodiscard]] ImageKey image_key(const std::string& name, const std::string& encoding, bool by_file_rules,
                                     const SourceLocation& where) const;
    /// Whether the colours of an image texture's file are converted by rules (ColorContext::file_color).
    [[nodiscard]] bool by_file_rules(const SceneTexture& source, const std::string& encoding, SpectrumRole role) const;
    /// Reads the files of textures and normal maps in parallel.
    void read_ahead(const SceneDescription& scene, int threads, LoadingProgress* progress);

    TextureId add(const TextureNode& node) {
        nodes.push_back(node);
        costs.push_back(cost_of(node));
        return static_cast<TextureId>(nodes.size() - 1);
    }
    [[nodiscard]] Rgb rgb(TextureId id, const TexturePoint& at) const override { return evaluate<Rgb>(id, at); }
    [[nodiscard]] Real real(TextureId id, const TexturePoint& at) const override { return evaluate<Real>(id, at); }
    [[nodiscard]] const TextureNode& node(TextureId id) const { return nodes[static_cast<std::size_t>(id)]; }
    [[nodiscard]] LookupCost cost_of(const TextureNode& node) const;
    [[nodiscard]] Status check_cost(const TextureNode& node, const SceneTexture& source) const;

    /// T is Rgb or float. Graphs are trees of a few nodes without cycles: textures use only those before them.
    template <class T>
    [[nodiscard]] T evaluate(TextureId id, const TexturePoint& at) const {
        const TextureNode& n = node(id);
        switch (n.kind) {
            case TextureNode::Kind::constant:
                if constexpr (std::is_same_v<T, Rgb>) return n.value;
                else return n.value.r;
            case TextureNode::Kind::scale:
                return evaluate<T>(n.a, at) * evaluate<Real>(n.amount, at);
            case TextureNode::Kind::mix: {
                const Real amount = evaluate<Real>(n.amount, at);
                T sum{};
                if (amount != 1) sum += evaluate<T>(n.a, at) * (1 - amount);
                if (amount != 0) sum += evaluate<T>(n.b, at) * amount;
                return sum;
            }
            case TextureNode::Kind::checkerboard: {
                const Vec2 st = mappings[static_cast<std::size_t>(n.mapping)].map(at);
                return evaluate<T>(odd(st.x) == odd(st.y) ? n.a : n.b, at);
            }
            case TextureNode::Kind::solid_checkerboard: {
                const Vec3 p = mappings[static_cast<std::size_t>(n.mapping)].texture_from_world.point(at.position);
                return evaluate<T>((odd(p.x) != odd(p.y)) == odd(p.z) ? n.a : n.b, at);
            }
            case TextureNode::Kind::image: {
                const TextureMapping& mapping = mappings[static_cast<std::size_t>(n.mapping)];
                const Vec2 st = mapping.map(at);
                const ImageStage& stage = stages[static_cast<std::size_t>(n.stage)];
                TexelFootprint room;
                const TexelFootprint* footprint = nullptr;
                if (at.footprint != nullptr && stage.filter.pyramid != nullptr) {
                    room = mapping.footprint(at);  // the rows of the image run downwards
                    room = {{room.first.x, -room.first.y}, {room.second.x, -room.second.y}};
                    footprint = &room;
                }
                if constexpr (std::is_same_v<T, Rgb>) return stage.rgb({st.x, 1 - st.y}, footprint);
                else return stage.real({st.x, 1 - st.y}, footprint);
            }
            case TextureNode::Kind::pattern: {
                const Pattern& pattern = *patterns[static_cast<std::size_t>(n.stage)];
                if constexpr (std::is_same_v<T, Rgb>) return pattern.rgb({*this, at});
                else return pattern.real({*this, at});
            }
        }
        return T{};
    }
};

}  // namespace raylex::transport
