#include "transport/textures/texture.h"

#include <algorithm>

#include "lpe/input/budgets.h"
#include "transport/textures/parameter_reader.h"
#include "transport/textures/texture_storage.h"

namespace raylex::transport {

LookupCost TextureTable::Storage::cost_of(const TextureNode& node) const {
    const auto at = [this](TextureId id) -> const LookupCost& { return costs[static_cast<std::size_t>(id)]; };
    LookupCost cost;
    switch (node.kind) {
        case TextureNode::Kind::constant:
        case TextureNode::Kind::image:
            break;
        case TextureNode::Kind::scale:
            (cost += at(node.a)) += at(node.amount);
            break;
        case TextureNode::Kind::mix:
            ((cost += at(node.a)) += at(node.b)) += at(node.amount);
            break;
        case TextureNode::Kind::checkerboard:
        case TextureNode::Kind::solid_checkerboard:  // one of the two inputs
            cost.work += std::max(at(node.a).work, at(node.b).work);
            cost.depth += std::max(at(node.a).depth, at(node.b).depth);
            break;
        case TextureNode::Kind::pattern:
            return pattern_costs[static_cast<std::size_t>(node.stage)];
    }
    return cost;
}

Status TextureTable::Storage::check_cost(const TextureNode& node, const SceneTexture& source) const {
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

Result<TextureNode> TextureTable::Storage::compile_pattern(const SceneTexture& source, const PatternFactory& factory,
                                                           SpectrumRole role, std::size_t visible) {
    LookupCost cost;
    PatternReader reader(source, color, [&](std::string_view name, const Rgb& fallback, bool spectrum) {
        auto input = spectrum ? rgb_input(source.parameters, name, fallback, role, visible)
                              : real_input(source.parameters, name, fallback.r, visible);
        if (input) cost += costs[static_cast<std::size_t>(*input)];
        return input;
    });
    Result<std::unique_ptr<Pattern>> made = factory(reader);
    if (!made) return std::move(made).error();
    if (reader.error()) return *reader.error();
    patterns.push_back(*std::move(made));
    looks_ahead = looks_ahead || patterns.back()->looks_ahead();
    pattern_costs.push_back(cost);
    TextureNode node;
    node.kind = TextureNode::Kind::pattern;
    node.stage = static_cast<std::int32_t>(patterns.size() - 1);
    return node;
}

/// pbrt-v4 multiplies a constant scale into the image texture, so that it acts before the image is inverted and clamped
/// (SpectrumScaledTexture::Create). For float textures, either input may be the constant.
TextureNode TextureTable::Storage::scaled_image(const TextureNode& scaled, bool spectrum) {
    const auto by = [&](TextureId image, TextureId factor) -> std::optional<TextureNode> {
        if (node(factor).kind != TextureNode::Kind::constant) return {};
        if (node(factor).value.r == 1) return node(image);
        if (node(image).kind != TextureNode::Kind::image) return {};
        TextureNode result = node(image);
        ImageStage stage = stages[static_cast<std::size_t>(result.stage)];
        stage.scale *= node(factor).value.r;
        result.stage = static_cast<std::int32_t>(stages.size());
        stages.push_back(stage);
        return result;
    };
    if (const auto image = by(scaled.a, scaled.amount)) return *image;
    const auto exchanged = spectrum ? std::nullopt : by(scaled.amount, scaled.a);
    return exchanged.value_or(scaled);
}

Result<TextureNode> TextureTable::Storage::compile_node(const SceneTexture& source, SpectrumRole role,
                                                        std::size_t visible) {
    if (source.type == "ptex" && pattern_registry().find("ptex") == nullptr)
        return error_at(source.location, "texture '" + source.name +
                                             "' is of type ptex, whose files raylex does not "
                                             "read; expected an image with texture coordinates: type imagemap");
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
    TextureNode node;
    if (source.type == "constant") {
        const TextureId value = child("value", 1);
        if (!reader.error()) node = nodes[static_cast<std::size_t>(value)];
    } else if (source.type == "scale") {
        node.kind = TextureNode::Kind::scale;
        node.a = child("tex", 1);
        node.amount = amount("scale", 1);
        if (!reader.error()) node = scaled_image(node, source.spectrum);
    } else if (source.type == "mix") {
        node.kind = TextureNode::Kind::mix;
        node.a = child("tex1", 0);
        node.b = child("tex2", 1);
        node.amount = amount("amount", 0.5f);
    } else if (source.type == "checkerboard") {
        const bool solid = reader.integer("dimension", 2, 2, 3) == 3;
        node.kind = solid ? TextureNode::Kind::solid_checkerboard : TextureNode::Kind::checkerboard;
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
    Result<TextureNode> result = compile_node(source, role, index);
    if (!result) return std::move(result).error();
    TextureNode node = *result;
    if (Status fits = check_cost(node, source); !fits) return fits.error();
    const auto fixed = [this](TextureId id) { return this->node(id).kind == TextureNode::Kind::constant; };
    const bool foldable = (node.kind == TextureNode::Kind::scale && fixed(node.a) && fixed(node.amount)) ||
                          (node.kind == TextureNode::Kind::mix && fixed(node.a) && fixed(node.b) && fixed(node.amount));
    TextureId id = add(node);
    if (foldable) {
        TextureNode constant;
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
    if (const auto called = sources_by_name.find(name); called != sources_by_name.end()) {
        for (auto i = called->second.rbegin(); i != called->second.rend(); ++i) {
            if (sources[*i].spectrum != spectrum) other_kind = true;
            else if (*i >= visible) later = true;
            else return compile(*i, role);
        }
        if (later)
            for (const std::size_t i : called->second)
                if (i >= visible && sources[i].spectrum == spectrum &&
                    texture_may_come_later(sources[visible], sources[i]))
                    return compile(i, role);
    }
    std::vector<std::string> known;
    for (const SceneTexture& source : sources)
        if (source.spectrum == spectrum) known.push_back(source.name);
    std::string hint;
    if (later) hint = "a texture of that name is defined further down: textures may only use earlier ones";
    else if (other_kind) hint = std::string("there is a ") + (spectrum ? "float" : "colour") + " texture of that name";
    else hint = near_miss(name, known);
    return error_at(
        where, std::string("unknown ") + kind + " texture '" + name + "' for parameter '" + parameter.name + "'", hint);
}

Result<TextureId> TextureTable::Storage::rgb_input(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                                   SpectrumRole role, std::size_t visible) {
    TextureNode constant;
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
    TextureNode constant;
    constant.value = Rgb(static_cast<Real>(*value));
    return add(constant);
}

TextureTable::TextureTable() : storage_(std::make_unique<Storage>()) {}
TextureTable::~TextureTable() = default;
TextureTable::TextureTable(TextureTable&&) noexcept = default;
TextureTable& TextureTable::operator=(TextureTable&&) noexcept = default;

Result<TextureTable> TextureTable::build(const SceneDescription& scene, const RenderSpace& space, int threads,
                                         LoadingProgress* progress) {
    TextureTable table;
    Storage& s = *table.storage_;
    s.sources = scene.textures;
    for (SceneTexture& source : s.sources) {
        source.to_world = space.placed(source.to_world);
        if (auto warning = mend_mapping(source.parameters)) s.warnings.push_back(*std::move(warning));
    }
    s.color = scene.color;
    s.scene_file = scene.file;
    for (std::size_t i = 0; i < s.sources.size(); ++i) s.sources_by_name[s.sources[i].name].push_back(i);
    s.read_ahead(scene, threads, progress);
    // Compiles every texture once, whether it is used or not, so that errors in any texture are reported.
    for (std::size_t i = 0; i < s.sources.size(); ++i)
        if (Result<TextureId> id = s.compile(i, SpectrumRole::albedo); !id) return std::move(id).error();
    // Look-ups mark parameters as used in the copies: copy the marks to the scene's own parameters.
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
    TextureNode constant;
    constant.value = value;
    return storage_->add(constant);
}

Result<TextureId> TextureTable::add_mix(TextureId first, TextureId second, TextureId amount) {
    TextureNode node;
    node.kind = TextureNode::Kind::mix;
    node.a = first;
    node.b = second;
    node.amount = amount;
    SceneTexture source;
    source.name = "share of a surface";
    if (Status fits = storage_->check_cost(node, source); !fits) return fits.error();
    const TextureId id = storage_->add(node);
    return is_constant(first) && is_constant(second) && is_constant(amount) ? add_constant(rgb(id, {})) : id;
}

Result<TextureId> TextureTable::rgb_parameter(const ParameterSet& set, std::string_view name, const Rgb& fallback,
                                              SpectrumRole role, const ColorContext& color) {
    storage_->color = color;
    return storage_->rgb_input(set, name, fallback, role, storage_->sources.size());
}

Result<TextureId> TextureTable::real_parameter(const ParameterSet& set, std::string_view name, Real fallback) {
    return storage_->real_input(set, name, fallback, storage_->sources.size());
}

Result<TextureId> TextureTable::named_real(std::string_view name, const SourceLocation& where) const {
    std::vector<std::string> known;
    for (std::size_t i = storage_->sources.size(); i-- > 0;) {
        if (storage_->sources[i].spectrum) continue;
        if (storage_->sources[i].name == name) return storage_->compiled.at({i, SpectrumRole::unbounded});
        known.push_back(storage_->sources[i].name);
    }
    return error_at(where, "unknown float texture '" + std::string(name) + "'", near_miss(name, known));
}

bool TextureTable::is_constant(TextureId id) const {
    return storage_->node(id).kind == TextureNode::Kind::constant;
}
Rgb TextureTable::rgb(TextureId id, const TexturePoint& at) const {
    return storage_->evaluate<Rgb>(id, at);
}
Real TextureTable::real(TextureId id, const TexturePoint& at) const {
    return storage_->evaluate<Real>(id, at);
}
bool TextureTable::looks_ahead() const {
    return storage_->looks_ahead;
}
void TextureTable::look_ahead(std::span<const TexturePoint> points) const {
    for (const std::unique_ptr<Pattern>& pattern : storage_->patterns)
        if (pattern->looks_ahead()) pattern->look_ahead(points);
}

}  // namespace raylex::transport
