// measured: RGL's .bsdf files.
#include "transport/materials/closures/measured.h"
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

class MeasuredMaterial final : public Material {
  public:
    explicit MeasuredMaterial(std::shared_ptr<const MeasuredReflectance> table) : table_(std::move(table)) {}
    void shade(const TextureTable&, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits)
            closures[i].set(Frame::from_normal_and_tangent(points[i].shading_normal, points[i].dpdu),
                            MeasuredClosure{table_.get()});
    }
    void append_lobes(std::vector<LobeId>& lobes) const override { lobes.push_back(lobes::measured); }

  private:
    std::shared_ptr<const MeasuredReflectance> table_;
};

Result<std::unique_ptr<Material>> make_measured(const SceneEntity& entity, const MaterialContext& context) {
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
    return std::unique_ptr<Material>(std::make_unique<MeasuredMaterial>(*std::move(table)));
}

}  // namespace

void register_measured_materials(Registry<MaterialFactory>& registry) {
    registry.add({"measured",
                  "a measured surface (Dupuy and Jakob 2018)",
                  {{"filename", ParameterType::string, "", "RGL's .bsdf file"}},
                  make_measured});
}

}  // namespace raylex::transport
