// Image textures: their files, read once however many textures and roles use them, and what becomes of their values.
#include <filesystem>

#include "transport/materials/parameter_reader.h"
#include "transport/materials/texture_storage.h"

namespace raylex::transport {

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

Result<TextureNode> TextureTable::Storage::compile_image(const SceneTexture& source, SpectrumRole role) {
    ParameterReader reader(source.parameters);
    const Parameter* file = source.parameters.find("filename");
    if (file == nullptr) return error_at(source.location, "imagemap texture without \"string filename\"");
    const std::string name = reader.string("filename", "");
    const std::string encoding = reader.string("encoding", "");
    ImageStage stage{};
    stage.sampler.wrap =
        static_cast<WrapMode>(reader.choice("wrap", {"repeat", "black", "clamp", "octahedralsphere"}, 0));
    const std::size_t filter =
        reader.choice("filter", {"bilinear", "point", "trilinear", "EWA", "unfiltered", "ewa"}, 0);
    stage.filter.kind = static_cast<TextureFilter>(filter == 5 ? 3 : filter);
    stage.sampler.nearest = stage.filter.kind == TextureFilter::point;
    stage.filter.most_anisotropic = reader.real("maxanisotropy", 8);
    if (!reader.error() && !(stage.filter.most_anisotropic >= 1))
        return error_at(reader.where(*source.parameters.find("maxanisotropy")),
                        "'maxanisotropy' is " + std::to_string(stage.filter.most_anisotropic) + "; expected 1 or more");
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
    if (stage.filter.kind != TextureFilter::unfiltered) {
        const auto [found, fresh] = pyramids.try_emplace(*image);
        if (fresh) found->second = ImagePyramid::of(**image);
        stage.filter.pyramid = &found->second;
    }
    stage.clamp_to_one = role == SpectrumRole::albedo;
    const auto& m = color.rendering_from_scene;
    stage.convert = source.spectrum && role != SpectrumRole::unbounded && m != ColorContext{}.rendering_from_scene;
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
