// Patterns: textures that compute their value from their parameters, other textures and the point, one call per
// look-up. Built-in textures are nodes of the texture table, which the compiler can inline; other textures are
// patterns, each with a type name of its own ("Texture "x" "spectrum" "NAME" ...").
//
// A pattern may write to display channels during rendering (PatternPoint::services), at every vertex of a camera path.
// In light samples, on light paths and in cutouts there are no services.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "display/services/registry.h"
#include "display/services/samples/display_services.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/parameter_reader.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

/// The interface with which a pattern evaluates its inputs.
class TextureLookup {
  public:
    virtual ~TextureLookup() = default;
    [[nodiscard]] virtual Rgb rgb(TextureId id, const TexturePoint& at) const = 0;
    [[nodiscard]] virtual Real real(TextureId id, const TexturePoint& at) const = 0;
};

/// The point at which a pattern is evaluated, with its inputs and services.
class PatternPoint {
  public:
    PatternPoint(const TextureLookup& textures, const TexturePoint& where) : at(where), textures_(textures) {}

    const TexturePoint& at;

    /// The value at this point of an input that PatternReader made.
    [[nodiscard]] Rgb rgb(TextureId input) const { return textures_.rgb(input, at); }
    [[nodiscard]] Real real(TextureId input) const { return textures_.real(input, at); }
    /// The display services, the row to write to, and the depth of the point in its path.
    [[nodiscard]] const VertexServices& services() const { return at.services; }

  private:
    const TextureLookup& textures_;
};

/// One object serves all threads. rgb() is called for "spectrum" textures, real() for "float" ones.
class Pattern {
  public:
    virtual ~Pattern() = default;
    [[nodiscard]] virtual Rgb rgb(const PatternPoint& point) const = 0;
    [[nodiscard]] virtual Real real(const PatternPoint& point) const = 0;
    /// Whether look_ahead() should be called: for patterns where a batch costs little more than a point (interpreted
    /// ones).
    [[nodiscard]] virtual bool looks_ahead() const { return false; }
    /// Receives the points at which this thread is about to shade a batch of hits. Most look-ups until the next call
    /// are at some of them, but this is not guaranteed.
    virtual void look_ahead(std::span<const TexturePoint> /*points*/) const {}
};

/// A ParameterReader for patterns: numbers, colours and textures become inputs. Every factory checks error() at the
/// end.
class PatternReader : public ParameterReader {
  public:
    using Resolve = std::function<Result<TextureId>(std::string_view name, const Rgb& fallback, bool spectrum)>;
    PatternReader(const SceneTexture& of, const ColorContext& colors, Resolve resolve)
        : ParameterReader(of.parameters), texture(of), color(colors), resolve_(std::move(resolve)) {}

    const SceneTexture& texture;  ///< its to_world leads to the space of TexturePoint::position
    const ColorContext& color;    ///< the meaning of the scene's colours

    TextureId rgb_input(std::string_view name, const Rgb& fallback) {
        return take(resolve_(name, fallback, true), TextureId{0});
    }
    TextureId real_input(std::string_view name, Real fallback) {
        return take(resolve_(name, Rgb(fallback), false), TextureId{0});
    }
    /// Reads an input: a colour in a spectrum texture, a number in a float texture.
    TextureId input(std::string_view name, Real fallback) {
        return texture.spectrum ? rgb_input(name, Rgb(fallback)) : real_input(name, fallback);
    }

  private:
    Resolve resolve_;
};

using PatternFactory = std::function<Result<std::unique_ptr<Pattern>>(PatternReader&)>;

/// All texture types by name. Those that the texture table compiles itself have no factory here.
Registry<PatternFactory>& pattern_registry();

}  // namespace raylex::transport
