// Image textures: their files, each read once for all textures and roles, and the processing of their values.
#include <filesystem>

#include "transport/color/color_space.h"
#include "transport/files/read_in_parallel.h"
#include "transport/textures/parameter_reader.h"
#include "transport/textures/texture_storage.h"

namespace raylex::transport {

namespace {

constexpr const char* by_rules = "by file rules";  // instead of an encoding

ReadImage read(const std::pair<std::string, std::string>& key) {
    ReadImage result;
    result.image = read_image(key.first, key.second == by_rules ? "linear" : key.second);
    Result<Image>& image = result.image;
    if (image && image->width > 0 && image->height > 0 && image->channels > 0)
        result.warning = clear_invalid_texels(*image, NegativeTexels::kept);
    return result;
}

/// The value of a parameter with a single string, or an empty string.
std::string string_of(const ParameterSet& set, std::string_view name) {
    const Parameter* parameter = set.find(name);
    return parameter != nullptr && parameter->strings.size() == 1 ? parameter->strings.front() : std::string();
}

}  // namespace

/// Files are relative to the scene file, as in pbrt-v4; if not found, to the file that names them.
TextureTable::Storage::ImageKey TextureTable::Storage::image_key(const std::string& name, const std::string& encoding,
                                                                 bool by_file_rules,
                                                                 const SourceLocation& where) const {
    namespace fs = std::filesystem;
    std::error_code ignored;
    fs::path path(name);
    if (path.is_relative()) {
        path = fs::path(scene_file).parent_path() / name;
        const fs::path beside = fs::path(where.file).parent_path() / name;
        if (!fs::exists(path, ignored) && fs::exists(beside, ignored)) path = beside;
    }
    return {path.lexically_normal().string(), by_file_rules ? by_rules : encoding};
}

// Numbers (roughness, alpha, eta) are never colours, and an encoding in the scene takes precedence.
bool TextureTable::Storage::by_file_rules(const SceneTexture& source, const std::string& encoding,
                                          SpectrumRole role) const {
    return color.file_color && source.spectrum && role != SpectrumRole::unbounded && encoding.empty();
}

void TextureTable::Storage::read_ahead(const SceneDescription& scene, int threads, LoadingProgress* progress) {
    std::map<ImageKey, bool> wanted;  // the value: whether the image is filtered
    for (const SceneTexture& source : sources) {
        const std::string file = string_of(source.parameters, "filename"),
                          encoding = string_of(source.parameters, "encoding"),
                          filter = string_of(source.parameters, "filter");
        if (source.type != "imagemap" || file.empty()) continue;
        const bool rules = by_file_rules(source, encoding, SpectrumRole::albedo);
        bool& filtered = wanted[image_key(file, encoding, rules, source.parameters.location)];
        filtered = filtered || (filter != "unfiltered" && !rules);  // colours are converted before they are averaged
    }
    for (const SceneEntity& material : scene.materials)
        if (const std::string map = string_of(material.parameters, "normalmap"); !map.empty())
            wanted.try_emplace(image_key(map, "linear", false, material.location), false);
    if (progress != nullptr) progress->begin("images", wanted.size());
    std::vector<std::pair<const ImageKey*, ReadImage*>> work;
    for (const auto& [key, filtered] : wanted) work.emplace_back(&key, &images_ahead[key]);
    read_in_parallel(work.size(), threads, [&](std::size_t i) {
        ReadImage& result = *work[i].second;
        result = read(*work[i].first);
        const Result<Image>& image = result.image;
        if (wanted.at(*work[i].first) && image && !image->pixels.empty()) result.pyramid = ImagePyramid::of(*image);
        if (progress != nullptr) progress->count();
    });
}

Result<const Image*> TextureTable::Storage::load_image(const std::string& name, const std::string& encoding,
                                                       bool by_file_rules, const SourceLocation& where) {
    const ImageKey key = image_key(name, encoding, by_file_rules, where);
    if (const auto known = image_by_file.find(key); known != image_by_file.end()) return known->second;
    auto ahead = images_ahead.extract(key);
    ReadImage result = ahead.empty() ? read(key) : std::move(ahead.mapped());
    Result<Image>& image = result.image;
    if (!image) {
        const Error& inner = image.error();
        return error_at(where, "image texture '" + name + "': " + inner.message, inner.hint);
    }
    if (image->width <= 0 || image->height <= 0 || image->channels <= 0)
        return error_at(where, "image texture '" + name + "' contains no pixels");
    if (result.warning) warnings.push_back(error_at(where, "image texture '" + name + "': " + *result.warning));
    if (!image->warning.empty()) warnings.push_back(error_at(where, "image texture '" + name + "': " + image->warning));
    if (by_file_rules) {
        auto convert = color.file_color(key.first);
        if (!convert) return error_at(where, "image texture '" + name + "': " + convert.error().message);
        convert_colors(*image, *convert);
        image->space = color.scene_space;
        image->other_space = false;
    }
    images.push_back(*std::move(image));
    image_by_file[key] = &images.back();
    if (result.pyramid) pyramids.emplace(&images.back(), *std::move(result.pyramid));
    return &images.back();
}

/// The filter of a texture; an unknown name means EWA, as in pbrt-v4, with a warning.
TextureFilter TextureTable::Storage::filter_of(const SceneTexture& source, ParameterReader& reader) {
    const std::string name = reader.string("filter", "bilinear");
    constexpr std::pair<const char*, TextureFilter> known[] = {{"bilinear", TextureFilter::bilinear},
                                                               {"point", TextureFilter::point},
                                                               {"trilinear", TextureFilter::trilinear},
                                                               {"EWA", TextureFilter::ewa},
                                                               {"ewa", TextureFilter::ewa},
                                                               {"unfiltered", TextureFilter::unfiltered}};
    for (const auto& [each, filter] : known)
        if (name == each) return filter;
    if (reader.error()) return TextureFilter::ewa;
    warnings.push_back(
        error_at(reader.where(*source.parameters.find("filter")),
                 "'filter' is '" + name + "'; expected bilinear, point, trilinear, EWA or unfiltered. EWA is used",
                 near_miss(name, {"bilinear", "point", "trilinear", "EWA", "unfiltered"})));
    return TextureFilter::ewa;
}

Result<TextureNode> TextureTable::Storage::compile_image(const SceneTexture& source, SpectrumRole role) {
    ParameterReader reader(source.parameters);
    const Parameter* file = source.parameters.find("filename");
    if (file == nullptr) return error_at(source.location, "imagemap texture without \"string filename\"");
    const std::string name = reader.string("filename", "");
    const std::string encoding = reader.string("encoding", "");
    ImageStage stage{};
    stage.sampler.wrap =
        static_cast<WrapMode>(reader.choice("wrap", {"repeat", "black", "clamp", "octahedralsphere"}, 0));
    stage.filter.kind = filter_of(source, reader);
    stage.sampler.nearest = stage.filter.kind == TextureFilter::point;
    stage.filter.most_anisotropic = reader.real("maxanisotropy", 8);
    if (!reader.error() && !(stage.filter.most_anisotropic >= 1))
        return error_at(reader.where(*source.parameters.find("maxanisotropy")),
                        "'maxanisotropy' is " + std::to_string(stage.filter.most_anisotropic) + "; expected 1 or more");
    stage.scale = reader.real("scale", 1);
    stage.invert = reader.boolean("invert", false);
    const TextureMapping mapping = read_mapping(reader, source.to_world);
    if (reader.error()) return *reader.error();
    Result<const Image*> image = load_image(name, encoding, by_file_rules(source, encoding, role), reader.where(*file));
    if (!image) return std::move(image).error();
    if ((*image)->other_space && source.spectrum && role != SpectrumRole::unbounded)
        warnings.push_back(error_at(reader.where(*file), "image texture '" + name + "': " + space_is_unknown));
    stage.sampler.image = *image;
    stage.sampler.alpha_varies = alpha_varies(**image);
    if (stage.filter.kind != TextureFilter::unfiltered) {
        const auto [found, fresh] = pyramids.try_emplace(*image);
        if (fresh) found->second = ImagePyramid::of(**image);
        stage.filter.pyramid = &found->second;
    }
    stage.clamp_to_one = role == SpectrumRole::albedo;
    const Matrix3 m = multiply(color.rendering_from_scene,
                               rgb_from_rgb(color.scene_space, (*image)->space, role != SpectrumRole::illuminant));
    const bool moves =
        color.rendering_from_scene != ColorContext{}.rendering_from_scene || (*image)->space != color.scene_space;
    stage.convert = source.spectrum && role != SpectrumRole::unbounded && moves;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) stage.matrix[r][c] = static_cast<Real>(m[r][c]);
    mappings.push_back(mapping);
    stages.push_back(stage);
    TextureNode node;
    node.kind = TextureNode::Kind::image;
    node.mapping = static_cast<std::int32_t>(mappings.size() - 1);
    node.stage = static_cast<std::int32_t>(stages.size() - 1);
    return node;
}

Result<TextureId> TextureTable::normal_map(const std::string& file, const SourceLocation& where) {
    Storage& s = *storage_;
    Result<const Image*> image = s.load_image(file, "linear", false, where);
    if (!image) return std::move(image).error();
    if ((*image)->channels < 3)
        return error_at(where, "normal map '" + file + "' has " + std::to_string((*image)->channels) +
                                   " channel(s); expected three: x, y and z of normals");
    ImageStage stage{};
    stage.sampler = {*image, WrapMode::repeat, false, false};  // unfiltered, as in pbrt
    s.mappings.emplace_back();
    s.stages.push_back(stage);
    TextureNode node;
    node.kind = TextureNode::Kind::image;
    node.mapping = static_cast<std::int32_t>(s.mappings.size() - 1);
    node.stage = static_cast<std::int32_t>(s.stages.size() - 1);
    return s.add(node);
}

}  // namespace raylex::transport
