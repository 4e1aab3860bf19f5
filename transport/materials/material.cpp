#include "transport/materials/material.h"

#include <algorithm>
#include <cstdint>

#include "transport/materials/material_inputs.h"
#include "transport/scene/used_surfaces.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {

Registry<MaterialFactory>& material_registry() {
    static Registry<MaterialFactory> registry = [] {
        Registry<MaterialFactory> r("material");
        register_plain_materials(r);
        register_layered_materials(r);
        register_hair_materials(r);
        register_measured_materials(r);
        register_subsurface_materials(r);
        register_composite_materials(r);
        register_raylex_materials(r);
        Registry<MaterialFactory> detailed("material");
        for (Registry<MaterialFactory>::Entry entry : r.entries()) {
            if (takes_normal_detail(entry.name))
                entry.parameters.insert(entry.parameters.end(), normal_detail_parameters().begin(),
                                        normal_detail_parameters().end());
            detailed.add(std::move(entry));
        }
        return detailed;
    }();
    return registry;
}

Result<MaterialTable> MaterialTable::build(const SceneDescription& scene, TextureTable& textures) {
    MaterialTable table;
    table.materials_.resize(scene.materials.size());
    table.filtered_ = materials_with_filtered_images(scene);
    table.filters_images_ = std::count(table.filtered_.begin(), table.filtered_.end(), 1) > 0;
    // As in pbrt-v4, a named material may use named ones before it, and a material without a name any of them.
    for (const bool named : {true, false})
        for (std::size_t i = 0; i < scene.materials.size(); ++i)
            if (scene.materials[i].name.empty() != named)
                if (Status made = table.add(i, scene, textures); !made) return made.error();
    const UsedSurfaces used(scene);
    for (const SceneEntity* each : used.materials())
        if (table.materials_[static_cast<std::size_t>(each - scene.materials.data())]->index_spectrum != nullptr)
            table.disperses_ = true;
    return table;
}

Status MaterialTable::add(std::size_t index, const SceneDescription& scene, TextureTable& textures) {
    const SceneEntity& entity = scene.materials[index];
    const auto entry = material_registry().require(entity.type, entity.location);
    if (!entry) return entry.error();
    Result<std::unique_ptr<Material>> material =
        (*entry)->factory(entity, {scene, textures, *this, static_cast<std::uint32_t>(index)});
    if (!material) {
        Error error = std::move(material).error();
        if (error.line == 0 && error.file.empty())
            error = error_at(entity.location, entity.type + " material: " + error.message, error.hint);
        return error;
    }
    materials_[index] = *std::move(material);
    if (takes_normal_detail(entity.type)) {
        Result<NormalDetail> detail = NormalDetail::read(entity, textures);
        if (!detail) return detail.error();
        turns_normals_ = turns_normals_ || !detail->empty();
        materials_[index]->normal_detail = *std::move(detail);
    }
    if (!entity.name.empty()) {
        names_.push_back(entity.name);
        named_.push_back(materials_[index].get());
    }
    return success();
}

std::vector<TextureId> MaterialTable::surface_shares() const {
    std::vector<TextureId> shares;
    for (const std::unique_ptr<Material>& material : materials_) shares.push_back(material->surface_share());
    return shares;
}

Result<const Material*> MaterialTable::find(std::string_view name, const SourceLocation& where) const {
    for (std::size_t i = names_.size(); i-- > 0;)
        if (names_[i] == name) return named_[i];
    return error_at(where, "no material named '" + std::string(name) + "' is defined before this one",
                    near_miss(name, names_));
}

namespace {

/// Per-thread lists of the hits of each material. They grow to the largest batch and scene, and then keep their size.
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

bool is_wanted(std::span<const std::uint8_t> wanted, std::size_t i) {
    return wanted.empty() || wanted[i] != 0;
}

void look_ahead(const TextureTable& textures, std::span<const SurfacePoint> points,
                std::span<const std::uint8_t> wanted) {
    thread_local std::vector<TexturePoint> at;
    at.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
        if (is_wanted(wanted, i)) at.push_back(texture_point(points[i]));
    textures.look_ahead(at);
}

}  // namespace

void MaterialTable::shade(const TextureTable& textures, std::span<const SurfacePoint> points, std::span<Bsdf> closures,
                          std::span<const std::uint8_t> wanted) const {
    if (textures.looks_ahead()) [[unlikely]]
        look_ahead(textures, points, wanted);
    thread_local Buckets buckets;
    buckets.fit(materials_.size(), points.size());
    for (std::size_t i = points.size(); i-- > 0;) {  // backwards, so that lists come out ascending
        if (!is_wanted(wanted, i)) {
            closures[i].set_black();
            continue;
        }
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
