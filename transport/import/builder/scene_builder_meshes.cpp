// Mesh files: read at the end, in parallel, and inserted in the order of calls.
#include <iterator>
#include <optional>

#include "transport/files/read_in_parallel.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/shapes/shapes.h"

namespace raylex::transport {

namespace {

struct ReadMesh {
    std::optional<Result<std::vector<SceneShape>>> shapes;
    std::vector<Error> warnings;
};

/// Inserts the elements of `extra` that begin at `place` before the element of `list` with that index; places ascend.
template <typename T>
void splice(std::vector<T>& list, std::vector<std::pair<std::size_t, std::vector<T>>>& extra) {
    std::vector<T> merged;
    std::size_t taken = 0;
    for (auto& [place, values] : extra) {
        std::move(list.begin() + static_cast<std::ptrdiff_t>(taken), list.begin() + static_cast<std::ptrdiff_t>(place),
                  std::back_inserter(merged));
        std::move(values.begin(), values.end(), std::back_inserter(merged));
        taken = place;
    }
    std::move(list.begin() + static_cast<std::ptrdiff_t>(taken), list.end(), std::back_inserter(merged));
    list = std::move(merged);
}

}  // namespace

/// The assignment of files to threads does not matter, since files are independent.
Status SceneBuilder::read_meshes() {
    if (meshes_.empty()) return success();
    if (progress_ != nullptr) progress_->begin("meshes", meshes_.size());
    std::vector<ReadMesh> read(meshes_.size());
    read_in_parallel(meshes_.size(), threads_, [&](std::size_t i) {
        const NamedMesh& mesh = meshes_[i];
        const ShapeContext context{mesh.to_world, mesh.placement.reverse_orientation, mesh.search};
        read[i].shapes = make_shapes("plymesh", mesh.parameters, context, read[i].warnings);
        if (progress_ != nullptr) progress_->count();
    });
    std::map<std::vector<SceneShape>*, std::vector<std::pair<std::size_t, std::vector<SceneShape>>>> shapes;
    std::vector<std::pair<std::size_t, std::vector<Error>>> warnings;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        const NamedMesh& mesh = meshes_[i];
        if (!*read[i].shapes) return read[i].shapes->error();
        std::vector<SceneShape> placed;
        append(placed, *std::move(*read[i].shapes), mesh.placement);
        const SourceLocation& where = mesh.parameters.location;
        const auto target = shapes_of(mesh.placement, where);
        if (!target) return target.error();
        if (*target != &scene_.shapes && mesh.placement.area_light.reference >= 0)
            read[i].warnings.push_back(
                error_at(where, "area lights do not emit from object instances (pbrt's rule); this shape is dark"));
        shapes[*target].emplace_back(mesh.shapes_before, std::move(placed));
        warnings.emplace_back(mesh.warnings_before, std::move(read[i].warnings));
        read[i] = {};
    }
    for (auto& [target, extra] : shapes) splice(*target, extra);
    splice(scene_.warnings, warnings);
    if (edge_scale_ != 1)
        for (auto& [target, extra] : shapes)
            for (SceneShape& shape : *target) shape.edge_length *= static_cast<Real>(edge_scale_);
    return success();
}

}  // namespace raylex::transport
