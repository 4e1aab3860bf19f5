// measured: RGL's .bsdf files.
#include "transport/materials/closures/measured.h"
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

MadeMaterial make_measured(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const std::string file = reader.string("filename", "");
    if (reader.error()) return *reader.error();
    const Parameter* parameter = entity.parameters.find("filename");
    if (file.empty())
        return error_at(parameter != nullptr ? reader.where(*parameter) : entity.location,
                        "measured material without \"string filename\"; expected a .bsdf file");
    auto table = MeasuredReflectance::read(file, context.scene.color);
    if (!table)
        return error_at(reader.where(*parameter), "measured material '" + file + "': " + table.error().message,
                        table.error().hint);
    if (!(*table)->warning.empty())
        context.textures.warn(
            error_at(reader.where(*parameter), "measured material '" + file + "': " + (*table)->warning));
    return reader.material(
        {lobes::measured}, [table = *std::move(table)](const TextureTable&, const SurfacePoint& p, Bsdf& closure) {
            closure.set(Frame::from_normal_and_tangent(p.shading_normal, p.dpdu), MeasuredClosure{table.get()});
        });
}

}  // namespace

void register_measured_materials(Registry<MaterialFactory>& registry) {
    registry.add({"measured",
                  "a measured surface (Dupuy and Jakob 2018)",
                  {{"filename", ParameterType::string, "", "RGL's .bsdf file"}},
                  make_measured});
}

}  // namespace raylex::transport
