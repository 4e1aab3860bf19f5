// Placeholders for missing files, if set_missing_files() enables them.
#include "transport/import/builder/scene_builder.h"

namespace raylex::transport {

void SceneBuilder::count_placeholder(const std::string& file, const SourceLocation& where) {
    scene_.placeholders.push_back(file);
    const Result<std::string> found = search_.find(file, where);
    warn(error_at(where, "cannot find file '" + file + "'; a magenta placeholder is used",
                  found ? std::string() : found.error().hint));
}

Status SceneBuilder::resolve_entity(SceneEntity& entity, bool float_texture) {
    while (missing_ == MissingFiles::placeholders) {
        const Parameter* missing = nullptr;
        for (const Parameter& each : entity.parameters.parameters)
            if ((each.name == "filename" || each.name == "normalmap") && each.type == ParameterType::string &&
                each.strings.size() == 1 && !search_.find(each.strings.front(), each.location))
                missing = &each;
        if (missing == nullptr) break;
        const std::string file = missing->strings.front();
        const SourceLocation where = missing->location;
        if (!make_placeholder(entity, *missing, float_texture)) break;
        count_placeholder(file, where);
    }
    return resolve_files(entity.parameters);
}

Status SceneBuilder::place_missing_mesh(const std::string& file, const ShapePlacement& placement,
                                        const SourceLocation& where) {
    count_placeholder(file, where);
    const Result<MaterialHandle> magenta = add_material("diffuse", {typed::rgb("reflectance", {1, 0, 1})}, where);
    if (!magenta) return magenta.error();
    MeshData box;
    box.patches = true;
    for (int i = 0; i < 8; ++i)
        box.positions.push_back({i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f});
    box.indices = {0, 2, 1, 3, 4, 5, 6, 7, 0, 1, 4, 5, 2, 6, 3, 7, 0, 4, 2, 6, 1, 3, 5, 7};
    ShapePlacement placed = placement;
    placed.material = *magenta;
    return add_mesh(box, placed, where);
}

}  // namespace raylex::transport
