#include "transport/materials/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>

#include "lpe/budgets.h"
#include "transport/materials/image_sampler.h"
#include "transport/materials/parameter_reader.h"
#include "transport/materials/pattern.h"
#include "transport/materials/texture_mapping.h"

namespace raylex::transport {

namespace {

/// What an image's values go through after interpolation.
struct ImageStage {
    ImageSampler sampler;
    Real scale = 1;
    bool invert = false;
    bool clamp_to_one = false;  ///< albedo
    bool convert = false;       ///< to the rendering space
    std::array<std::array<Real, 3>, 3> matrix{};

    [[nodiscard]] Real real(const Vec2& st) const {
        const Real value = scale * sampler.real(st);
        return invert ? std::max(Real(0), 1 - value) : value;
    }
    [[nodiscard]] Rgb rgb(const Vec2& st) const {
        Rgb c = sampler.rgb(st) * scale;
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

/// One compiled texture: a node of the graph, its children by index.
struct Node {
    enum class Kind : std::uint8_t { constant, scale, mix, checkerboard, solid_checkerboard, image, pattern };
    Kind kind = Kind::constant;
    Rgb value;                 ///< constant (a float texture's in all three)
    TextureId a = 0, b = 0;    ///< scale: a; mix, checkerboards: a and b
    TextureId amount = 0;      ///< scale, mix: a float texture
    std::int32_t mapping = 0;  ///< checkerboard, image
    std::int32_t stage = 0;    ///< image: its stage; pattern: which
};

/// What one look-up costs at most, its inputs included: textures that use one twice each grow like powers of two.
struct LookupCost {
    double work = 1;  ///< textures looked up; a double does not overflow
    std::uint64_t depth = 1;

    LookupCost& operator+=(const LookupCost& input) {
        work += input.work;
        depth = std::max(depth, input.depth + 1);
        return *this;
    }
};

bool odd(Real x) {
    const Real half = std::floor(x) * 0.5f;
    return half != std::floor(half);
}

}  // namespace

struct TextureTable::Storage final : TextureLookup {
    std::vector<Node> nodes;
    std::vector<LookupCost> costs;  // parallel to nodes
    std::vector<std::unique_ptr<Pattern>> patterns;
    std::vector<LookupCost> pattern_costs;  // parallel to patterns
    std::vector<TextureMapping> mappings;
    std::vector<ImageStage> stages;
    std::deque<Image> images;                                                   // addresses stay
    std::map<std::pair<std::string, std::string>, const Image*> image_by_file;  // (path, encoding)

    std::vector<SceneTexture> sources;                                             // to_world: to render space
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
    Result<Node> compile_node(const SceneTexture& source, SpectrumRole role, std::size_t visible);
    Result<Node> compile_image(const SceneTexture& source, SpectrumRole role);
    Result<Node> compile_pattern(const SceneTexture& source, const PatternFactory& factory, SpectrumRole role,
                                 std::size_t visible);
    Result<const Image*> load_image(const std::string& name, const std::string& encoding, bool by_file_rules,
                                    const SourceLocation& where);

    TextureId add(const Node& node) {
        nodes.push_back(node);
        costs.push_back(cost_of(node));
        return static_cast<TextureId>(nodes.size() - 1);
    }
    [[nodiscard]] Rgb rgb(TextureId id, const TexturePoint& at) const override { return evaluate<Rgb>(id, at); }
    [[nodiscard]] Real real(TextureId id, const TexturePoint& at) const override { return evaluate<Real>(id, at); }
    [[nodiscard]] const Node& node(TextureId id) const { return nodes[static_cast<std::size_t>(id)]; }
    [[nodiscard]] LookupCost cost_of(const Node& node) const;
    [[nodiscard]] Status check_cost(const Node& node, const SceneTexture& source) const;

    /// T is Rgb or float. Graphs are trees of a few nodes without cycles: textures see only those before them.
    template <class T>
    [[nodiscard]] T evaluate(TextureId id, const TexturePoint& at) const {
        const Node& n = node(id);
        switch (n.kind) {
            case Node::Kind::constant:
                if constexpr (std::is_same_v<T, Rgb>) return n.value;
                else return n.value.r;
            case Node::Kind::scale:
                return evaluate<T>(n.a, at) * evaluate<Real>(n.amount, at);
            case Node::Kind::mix: {
                const Real amount = evaluate<Real>(n.amount, at);
                T sum{};
                if (amount != 1) sum += evaluate<T>(n.a, at) * (1 - amount);
                if (amount != 0) sum += evaluate<T>(n.b, at) * amount;
                return sum;
            }
            case Node::Kind::checkerboard: {
                const Vec2 st = mappings[static_cast<std::size_t>(n.mapping)].map(at);
                return evaluate<T>(odd(st.x) == odd(st.y) ? n.a : n.b, at);
            }
            case Node::Kind::solid_checkerboard: {
                const Vec3 p = mappings[static_cast<std::size_t>(n.mapping)].texture_from_world.point(at.position);
                return evaluate<T>((odd(p.x) != odd(p.y)) == odd(p.z) ? n.a : n.b, at);
            }
            case Node::Kind::image: {
                const Vec2 st = mappings[static_cast<std::size_t>(n.mapping)].map(at);
                const ImageStage& stage = stages[static_cast<std::size_t>(n.stage)];
                if constexpr (std::is_same_v<T, Rgb>) return stage.rgb({st.x, 1 - st.y});
                else return stage.real({st.x, 1 - st.y});
            }
            case Node::Kind::pattern: {
                const Pattern& pattern = *patterns[static_cast<std::size_t>(n.stage)];
                if constexpr (std::is_same_v<T, Rgb>) return pattern.rgb({*this, at});
                else return pattern.real({*this, at});
            }
        }
        return T{};
    }
};

LookupCost TextureTable::Storage::cost_of(const Node& node) const {
    const auto at = [this](TextureId id) -> const LookupCost& { return costs[static_cast<std::size_t>(id)]; };
    LookupCost cost;
    switch (node.kind) {
        case Node::Kind::constant:
        case Node::Kind::image:
            break;
        case Node::Kind::scale:
            (cost += at(node.a)) += at(node.amount);
            break;
        case Node::Kind::mix:
            ((cost += at(node.a)) += at(node.b)) += at(node.amount);
            break;
        case Node::Kind::checkerboard:
        case Node::Kind::solid_checkerboard:  // one of the two
            cost.work += std::max(at(node.a).work, at(node.b).work);
            cost.depth += std::max(at(node.a).depth, at(node.b).depth);
            break;
        case Node::Kind::pattern:
            return pattern_costs[static_cast<std::size_t>(node.stage)];
    }
    return cost;
}

Status TextureTable::Storage::check_cost(const Node& node, const SceneTexture& source) const {
    const LookupCost cost = cost_of(node);
    const SourceLocation& where = source.location;
    const auto refuse = [&](Budget which, const std::string& what) {
        return over_budget(which, "texture '" + source.name + "' " + what, where.file, where.line, where.column);
    };
    if (cost.depth > budget(Budget::texture_depth))
        return refuse(Budget::texture_depth, "uses textures inside one another too deep");
    if (cost.work > static_cast<double>(budget(Budget::texture_work)))
        return refuse(Budget::texture_work, "looks up too many textures for one value");
    return success();
}

Result<const Image*> TextureTable::Storage::load_image(const std::string& name, const std::string& encoding,
                                                       bool by_file_rules, const SourceLocation& where) {
    namespace fs = std::filesystem;
    // Relative to the scene file, as in pbrt-v4; else to the file that names it.
    std::error_code ignored;
    fs::path path(name);
    if (path.is_relative()) {
        path = fs::path(scene_file).parent_path() / name;
        const fs::path beside = fs::path(where.file).parent_path() / name;
        if (!fs::exists(path, ignored) && fs::exists(beside, ignored)) path = beside;
    }
    const std::pair key{path.lexically_normal().string(), by_file_rules ? "by file rules" : encoding};
    if (const auto known = image_by_file.find(key); known != image_by_file.end()) return known->second;
    Result<Image> image = read_image(path.string(), by_file_rules ? "linear" : encoding);
    if (!image) {
        const Error& inner = image.error();
        return error_at(where, "image texture '" + name + "': " + inner.message, inner.hint);
    }
    if (image->width <= 0 || image->height <= 0 || image->channels <= 0)
        return error_at(where, "image texture '" + name + "' holds no pixels");
    if (const auto invalid = clear_invalid_texels(*image))
        warnings.push_back(error_at(where, "image texture '" + name + "': " + *invalid));
    if (by_file_rules) {
        auto convert = color.file_color(path.string());
        if (!convert) return error_at(where, "image texture '" + name + "': " + convert.error().message);
        convert_colors(*image, *convert);
    }
    images.push_back(*std::move(image));
    image_by_file[key] = &images.back();
    return &images.back();
}

Result<Node> TextureTable::Storage::compile_image(const SceneTexture& source, SpectrumRole role) {
    ParameterReader reader(source.parameters);
    const Parameter* file = source.parameters.find("filename");
    if (file == nullptr) return error_at(source.location, "imagemap texture without \"string filename\"");
    const std::string name = reader.string("filename", "");
    const std::string encoding = reader.string("encoding", "");
    ImageStage stage{};
    stage.sampler.wrap =
        static_cast<WrapMode>(reader.choice("wrap", {"repeat", "black", "clamp", "octahedralsphere"}, 0));
    stage.sampler.nearest = reader.choice("filter", {"bilinear", "point", "trilinear", "ewa", "EWA"}, 0) == 1;
    reader.real("maxanisotropy", 8);
    stage.scale = reader.real("scale", 1);
    stage.invert = reader.boolean("invert", false);
    const TextureMapping mapping = read_mapping(reader, source.to_world);
    if (reader.error()) return *reader.error();
    // Numbers (roughness, alpha, eta) are never colours, and an encoding in the scene is the artist's word.
    const bool by_file_rules =
        color.file_color && source.spectrum && role != SpectrumRole::unbounded && encoding.empty();
    Result<const Image*> image = load_image(name, encoding, by_file_rules, reader.where(*file));
    if (!image) return std::move(image).error();
    stage.sampler.image = *image;
    stage.sampler.alpha_varies = alpha_varies(**image);
    stage.clamp_to_one = role == SpectrumRole::albedo;
    const auto& m = color.rendering_from_scene;
    stage.convert = source.spectrum && role != SpectrumRole::unbounded && m != ColorContext{}.rendering_from_scene;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) stage.matrix[r][c] = static_cast<Real>(m[r][c]);
    mappings.push_back(mapping);
    stages.push_back(stage);
    Node node;
    node.kind = Node::Kind::image;
    node.mapping = static_cast<std::int32_t>(mappings.size() - 1);
    node.stage = static_cast<std::int32_t>(stages.size() - 1);
    return node;
}

Result<Node> TextureTable::Storage::compile_pattern(const SceneTexture& source, const PatternFactory& factory,
                                                    SpectrumRole role, std::size_t visible) {
    LookupCost cost;
    PatternReader reader(source, [&](std::string_view name, const Rgb& fallback, bool spectrum) {
        auto input = spectrum ? rgb_input(source.parameters, name, fallback, role, visible)
                              : real_input(source.parameters, name, fallback.r, visible);
        if (input) cost += costs[static_cast<std::size_t>(*input)];
        return input;
    });
    Result<std::unique_ptr<Pattern>> made = factory(reader);
    if (!made) return std::move(made).error();
    if (reader.error()) return *reader.error();
    patterns.push_back(*std::move(made));
    pattern_costs.push_back(cost);
    Node node;
    node.kind = Node::Kind::pattern;
    node.stage = static_cast<std::int32_t>(patterns.size() - 1);
    return node;
}

Result<Node> TextureTable::Storage::compile_node(const SceneTexture& source, SpectrumRole role, std::size_t visible) {
    const auto known = pattern_registry().require(source.type, source.location);
    if (!known) return known.error();
    if ((*known)->factory) return compile_pattern(source, (*known)->factory, role, visible);
    ParameterReader reader(source.parameters);
    const auto child = [&](std::string_view name, Real fallback) {
        return source.spectrum ? reader.take(rgb_input(source.parameters, name, Rgb(fallback), role, visible), 0)
                               : reader.take(real_input(source.parameters, name, fallback, visible), 0);
    };
    const auto amount = [&](std::string_view name, Real fallback) {
        return reader.take(real_input(source.parameters, name, fallback, visible), 0);
    };
    Node node;
    if (source.type == "constant") {
        const TextureId value = child("value", 1);
        if (!reader.error()) node = nodes[static_cast<std::size_t>(value)];
    } else if (source.type == "scale") {
        node.kind = Node::Kind::scale;
        node.a = child("tex", 1);
        node.amount = amount("scale", 1);
    } else if (source.type == "mix") {
        node.kind = Node::Kind::mix;
        node.a = child("tex1", 0);
        node.b = child("tex2", 1);
        node.amount = amount("amount", 0.5f);
    } else if (source.type == "checkerboard") {
        const bool solid = reader.integer("dimension", 2, 2, 3) == 3;
        node.kind = solid ? Node::Kind::solid_checkerboard : Node::Kind::checkerboard;
        node.a = child("tex1", 1);
        node.b = child("tex2", 0);
        TextureMapping mapping;
        if (solid) mapping.texture_from_world = source.to_world.inverse();
        else mapping = read_mapping(reader, source.to_world);
        mappings.push_back(mapping);
        node.mapping = static_cast<std::int32_t>(mappings.size() - 1);
    } else {
        return compile_image(source, role);
    }
    if (reader.error()) return *reader.error();
    return node;
}

Result<TextureId> TextureTable::Storage::compile(std::size_t index, SpectrumRole role) {
    const SceneTexture& source = sources[index];
    if (!source.spectrum) role = SpectrumRole::unbounded;  // floats have no role
    if (const auto known = compiled.find({index, role}); known != compiled.end()) return known->second;
    Result<Node> result = compile_node(source, role, index);
    if (!result) return std::move(result).error();
    Node node = *result;
    if (Status fits = check_cost(node, source); !fits) return fits.error();
    const auto fixed = [this](TextureId id) { return this->node(id).kind == Node::Kind::constant; };
    const bool foldable = (node.kind == Node::Kind::scale && fixed(node.a) && fixed(node.amount)) ||
                          (node.kind == Node::Kind::mix && fixed(node.a) && fixed(node.b) && fixed(node.amount));
    TextureId id = add(node);
    if (foldable) {
        Node constant;
        constant.value = evaluate<Rgb>(id, {});
        nodes.back() = constant;
        costs.back() = {};
    }
    compiled[{index, role}] = id;
    return id;
}

Result<TextureId> TextureTable::Storage::reference(const Parameter& parameter, const SourceLocation& where,
                                                   bool spectrum, SpectrumRole role, std::size_t visible) {
    const char* kind = spectrum ? "colour" : "float";
    if (parameter.strings.size() != 1)
        return error_at(where, "texture parameter '" + parameter.name + "' must name one " + kind + " texture");
    const std::string& name = parameter.strings.front();
    bool other_kind = false, later = false;
    if (const auto called = sources_by_name.find(name); called != sources_by_name.end())
        for (auto i = called->second.rbegin(); i != called->second.rend(); ++i) {
            if (sources[*i].spectrum != spectrum) other_kind = true;
            else if (*i >= visible) later = true;
            else return compile(*i, role);
        }
    std::vector<std::string> known;
    for (const SceneTexture& source : sources)
        if (source.spectrum == spectrum) known.push_back(source.name);
    std::string hint;
    if (later) hint = "a texture of that name is defined further down: textures may only use earlier ones";
    else if (other_kind) hint = std::string("there is a ") + (spectrum ? "float" : "colour") + " texture of that name";
    else if (const std::string near = nearest_name(name, known); !near.empty()) hint = "did you mean '" + near + "'?";
    return error_at(
        where, std::string("unknown ") + kind + " texture '" + name + "' for parameter '" + parameter.name + "'", hint);
}

Result<TextureId> TextureTable::Storage::rgb_input(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                                   SpectrumRole role, std::size_t visible) {
    Node constant;
    constant.value = fallback;
    const Parameter* parameter = set.find(name);
    if (parameter == nullptr) return add(constant);
    const SourceLocation& where = parameter->location.line != 0 ? parameter->location : set.location;
    if (parameter->type == ParameterType::texture) return reference(*parameter, where, true, role, visible);
    Result<Rgb> value = resolve_spectrum(*parameter, role, color);
    if (!value) return std::move(value).error();
    constant.value = *value;
    return add(constant);
}

Result<TextureId> TextureTable::Storage::real_input(const ParameterSet& set, std::string_view name, Real fallback,
                                                    std::size_t visible) {
    const Parameter* parameter = set.find(name);
    if (parameter != nullptr && parameter->type == ParameterType::texture) {
        const SourceLocation& where = parameter->location.line != 0 ? parameter->location : set.location;
        return reference(*parameter, where, false, SpectrumRole::unbounded, visible);
    }
    Result<double> value = set.real_or(name, static_cast<double>(fallback));
    if (!value) return std::move(value).error();
    Node constant;
    constant.value = Rgb(static_cast<Real>(*value));
    return add(constant);
}

TextureTable::TextureTable() : storage_(std::make_unique<Storage>()) {}
TextureTable::~TextureTable() = default;
TextureTable::TextureTable(TextureTable&&) noexcept = default;
TextureTable& TextureTable::operator=(TextureTable&&) noexcept = default;

Result<TextureTable> TextureTable::build(const SceneDescription& scene, const RenderSpace& space) {
    TextureTable table;
    Storage& s = *table.storage_;
    s.sources = scene.textures;
    for (SceneTexture& source : s.sources) source.to_world = space.placed(source.to_world);
    s.color = scene.color;
    s.scene_file = scene.file;
    for (std::size_t i = 0; i < s.sources.size(); ++i) s.sources_by_name[s.sources[i].name].push_back(i);
    // Compiled once here whether used or not, so that a mistake in any texture is reported.
    for (std::size_t i = 0; i < s.sources.size(); ++i)
        if (Result<TextureId> id = s.compile(i, SpectrumRole::albedo); !id) return std::move(id).error();
    // A look-up marks parameters as used in the copies: carry that back to the scene's own.
    for (std::size_t i = 0; i < s.sources.size(); ++i)
        for (std::size_t p = 0; p < s.sources[i].parameters.parameters.size(); ++p)
            if (s.sources[i].parameters.parameters[p].used) scene.textures[i].parameters.parameters[p].used = true;
    return table;
}

const std::vector<Error>& TextureTable::warnings() const {
    return storage_->warnings;
}

void TextureTable::warn(Error warning) {
    storage_->warnings.push_back(std::move(warning));
}

TextureId TextureTable::add_constant(const Rgb& value) {
    Node constant;
    constant.value = value;
    return storage_->add(constant);
}

Result<TextureId> TextureTable::rgb_parameter(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                              SpectrumRole role, const ColorContext& color) {
    storage_->color = color;
    return storage_->rgb_input(set, name, fallback, role, storage_->sources.size());
}

Result<TextureId> TextureTable::real_parameter(const ParameterSet& set, std::string_view name, Real fallback) {
    return storage_->real_input(set, name, fallback, storage_->sources.size());
}

Result<TextureId> TextureTable::normal_map(const std::string& file, const SourceLocation& where) {
    Storage& s = *storage_;
    Result<const Image*> image = s.load_image(file, "linear", false, where);
    if (!image) return std::move(image).error();
    if ((*image)->channels < 3)
        return error_at(where, "normal map '" + file + "' has " + std::to_string((*image)->channels) +
                                   " channel(s); expected three: x, y and z of normals");
    ImageStage stage{};
    stage.sampler = {*image, WrapMode::repeat, false, false};
    s.mappings.emplace_back();
    s.stages.push_back(stage);
    Node node;
    node.kind = Node::Kind::image;
    node.mapping = static_cast<std::int32_t>(s.mappings.size() - 1);
    node.stage = static_cast<std::int32_t>(s.stages.size() - 1);
    return s.add(node);
}

Result<TextureId> TextureTable::named_real(std::string_view name, const SourceLocation& where) const {
    std::vector<std::string> known;
    for (std::size_t i = storage_->sources.size(); i-- > 0;) {
        if (storage_->sources[i].spectrum) continue;
        if (storage_->sources[i].name == name) return storage_->compiled.at({i, SpectrumRole::unbounded});
        known.push_back(storage_->sources[i].name);
    }
    const std::string near = nearest_name(name, known);
    return error_at(where, "unknown float texture '" + std::string(name) + "'",
                    near.empty() ? std::string() : "did you mean '" + near + "'?");
}

bool TextureTable::is_constant(TextureId id) const {
    return storage_->node(id).kind == Node::Kind::constant;
}
Rgb TextureTable::rgb(TextureId id, const TexturePoint& at) const {
    return storage_->evaluate<Rgb>(id, at);
}
Real TextureTable::real(TextureId id, const TexturePoint& at) const {
    return storage_->evaluate<Real>(id, at);
}

}  // namespace raylex::transport
