#include "transport/materials/material.h"

#include <algorithm>
#include <cstdint>

#include "transport/materials/material_inputs.h"
#include "transport/materials/pattern.h"

namespace raylex::transport {

Registry<MaterialFactory>& material_registry() {
    static Registry<MaterialFactory> registry = [] {
        Registry<MaterialFactory> r("material");
        register_plain_materials(r);
        register_layered_materials(r);
        register_composite_materials(r);
        register_raylex_materials(r);
        return r;
    }();
    return registry;
}

Result<MaterialTable> MaterialTable::build(const SceneDescription& scene, TextureTable& textures) {
    MaterialTable table;
    for (const SceneEntity& entity : scene.materials) {
        const auto entry = material_registry().require(entity.type, entity.location);
        if (!entry) return entry.error();
        const auto salt = static_cast<std::uint32_t>(table.materials_.size());
        Result<std::unique_ptr<Material>> material = (*entry)->factory(entity, {scene, textures, table, salt});
        if (!material) {
            Error error = std::move(material).error();
            if (error.line == 0 && error.file.empty())
                error = error_at(entity.location, entity.type + " material: " + error.message, error.hint);
            return error;
        }
        table.materials_.push_back(*std::move(material));
        table.names_.push_back(entity.name);
    }
    return table;
}

Result<const Material*> MaterialTable::find(std::string_view name, const SourceLocation& where) const {
    for (std::size_t i = names_.size(); i-- > 0;)
        if (!name.empty() && names_[i] == name) return materials_[i].get();
    const std::string near = nearest_name(name, names_);
    return error_at(where, "no material named '" + std::string(name) + "' is defined before this one",
                    near.empty() ? std::string() : "did you mean '" + near + "'?");
}

namespace {

/// Per-thread lists of the hits of each material; they grow to the largest batch and scene once, then stay.
struct Buckets {
    static constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> head;   // [material] first hit; `none` between calls
    std::vector<std::uint32_t> next;   // [hit]
    std::vector<std::uint32_t> order;  // hits, one material after another
    std::vector<std::uint32_t> used;   // materials of this batch

    void fit(std::size_t materials, std::size_t hits) {
        if (head.size() < materials) head.resize(materials, none);
        if (next.size() < hits) {
            next.resize(hits);
            order.resize(hits);
        }
        used.clear();
        if (used.capacity() < std::min(materials, hits)) used.reserve(std::min(materials, hits));
    }
};

}  // namespace

void MaterialTable::shade(const TextureTable& textures, std::span<const SurfacePoint> points, std::span<Bsdf> closures,
                          display::DisplayServices* display) const {
    const ShadingScope scope(display);
    thread_local Buckets buckets;
    buckets.fit(materials_.size(), points.size());
    for (std::size_t i = points.size(); i-- > 0;) {  // backwards, so that lists come out ascending
        const auto material = static_cast<std::size_t>(points[i].material);
        if (buckets.head[material] == Buckets::none) buckets.used.push_back(static_cast<std::uint32_t>(material));
        buckets.next[i] = buckets.head[material];
        buckets.head[material] = static_cast<std::uint32_t>(i);
    }
    for (const std::uint32_t material : buckets.used) {
        std::size_t count = 0;
        for (std::uint32_t i = buckets.head[material]; i != Buckets::none; i = buckets.next[i])
            buckets.order[count++] = i;
        buckets.head[material] = Buckets::none;
        materials_[material]->shade(textures, {buckets.order.data(), count}, points, closures);
    }
}

}  // namespace raylex::transport
