// The event classes of path vertices, looked up once per scene.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "display/services/liveness/liveness.h"
#include "display/services/samples/lpe_services.h"
#include "lpe/channels/lobe_slots.h"
#include "transport/embree/embree_scene.h"
#include "transport/lights/light_table.h"
#include "transport/materials/material.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// The scene's tables, all immutable while rendering.
struct SceneView {
    const EmbreeScene* geometry = nullptr;
    const TextureTable* textures = nullptr;
    const MaterialTable* materials = nullptr;
    const LightTable* lights = nullptr;
    const MediumTable* media = nullptr;
    EffectSet general_code{};  ///< SceneDescription::general_code
    bool moves = false;        ///< is_moving(): camera rays draw a time
    /// Each sample draws one wavelength from it; null if no index of refraction depends on the wavelength.
    const WavelengthDistribution* wavelengths = nullptr;

    /// Whether each sample draws a time for its rays: something moves, or the code for motion is forced.
    [[nodiscard]] bool asks_for_times() const { return moves || general_code.contains(Effect::motion); }
    /// Whether paths check for media: the scene has media, or the code for media is forced.
    [[nodiscard]] bool asks_for_media() const { return media->any() || general_code.contains(Effect::media); }
    /// Whether hits and shadow rays are tested for cutouts and interfaces, which light can pass.
    [[nodiscard]] bool tests_alpha() const { return geometry->has_alpha() || general_code.contains(Effect::alpha); }
    /// Opacity from 0 to 1 at a point of a shape that has a cutout.
    [[nodiscard]] Real opacity(const ShapeGeometry& shape, const SurfacePoint& point) const {
        return std::clamp(
            textures->real(shape.alpha, {point.u, point.v, point.position, point.geometric_normal, nullptr, {}}),
            Real(0), Real(1));
    }
};

/// User events of surfaces, as RenderMan's default options number them (lpe:user2 "...Albedo", lpe:user6 "Normal"): U2,
/// the albedo, and U6, the shading normal in camera space.
enum class UserLobe : std::uint8_t { albedo, normal };
/// The lobe labels of these events. Lobe slots map the labels to numbers.
inline constexpr std::array<const char*, 2> user_lobes{"albedo", "normal"};

/// The event classes of the scene's events in the program of the render's channels, as tables for inner loops.
class EventTable {
  public:
    EventTable() = default;
    /// Without `prunes` all light is simulated, even if no channel takes it (to measure what pruning saves).
    /// `regularizes`: the integrator's trait.
    EventTable(const display::LpeSetup& setup, const SceneView& scene, const lpe::LobeSlots& slots, bool prunes = true,
               bool regularizes = false);

    /// The class of a scattering by `lobe` at an object with this label. For a medium (medium_label()) `lobe` is
    /// ignored.
    [[nodiscard]] lpe::EventClass scatter(std::int32_t label, LobeId lobe) const {
        return scatter_[static_cast<std::size_t>(label) * lobe_count_ + lobe];
    }
    /// The class of passing straight through a cutout, or through an interface without a surface.
    [[nodiscard]] lpe::EventClass straight(std::int32_t label) const {
        return straight_[static_cast<std::size_t>(label)];
    }
    /// The label of a medium. These labels follow those of the objects.
    [[nodiscard]] std::int32_t medium_label(std::int32_t medium) const { return first_medium_label_ + medium; }
    /// The terminal O of light that a medium emits.
    [[nodiscard]] lpe::EventClass emission() const { return emission_; }
    /// The class of a light's terminal event: L, or B for an infinite light, with the light group.
    [[nodiscard]] lpe::EventClass terminal(std::uint32_t light) const { return terminal_[light]; }
    /// The class of a user event of a surface with this label. Its terminal is user_terminal(), an L without a group.
    [[nodiscard]] lpe::EventClass user(std::int32_t label, UserLobe lobe) const {
        return user_[static_cast<std::size_t>(label) * user_lobes.size() + static_cast<std::size_t>(lobe)];
    }
    [[nodiscard]] lpe::EventClass user_terminal() const { return user_terminal_; }
    /// Whether any channel names this user event.
    [[nodiscard]] bool wants(UserLobe lobe) const { return wants_user_[static_cast<std::size_t>(lobe)]; }
    [[nodiscard]] bool wants_user() const {
        return std::any_of(wants_user_.begin(), wants_user_.end(), [](bool wanted) { return wanted; });
    }
    /// False if no channel has an expression: then moves may be skipped.
    [[nodiscard]] bool any() const { return any_; }
    [[nodiscard]] bool prunes() const { return prunes_; }
    /// The events of scattering by a material at an object with this label. For a medium, pass medium_label() and
    /// SurfacePoint::no_material.
    [[nodiscard]] std::span<const lpe::EventClass> scatterings(std::int32_t label, std::int32_t material) const {
        const Row& row = row_of(label, material);
        return {by_kind_.data() + row.begin, row.count};
    }
    /// The events of scatterings() that have a density: there light can be sampled and subpaths can be connected.
    [[nodiscard]] std::span<const lpe::EventClass> with_density(std::int32_t label, std::int32_t material) const {
        const Row& row = row_of(label, material);
        return {by_kind_.data() + row.begin, row.with_density};
    }
    [[nodiscard]] const display::Liveness& liveness() const { return liveness_; }
    /// The events of this scene, for liveness. Its lists of scatterings are empty unless prunes().
    [[nodiscard]] display::Liveness::Alphabet alphabet() const;

  private:
    void find_scatterings(const MaterialTable& materials, std::size_t media, bool regularizes);
    void find_scatterings_in_use(const EmbreeScene& geometry, const MediumTable& media);
    std::vector<lpe::EventClass> scatter_, straight_, terminal_, user_;
    lpe::EventClass emission_ = 0, user_terminal_ = 0;
    std::array<bool, user_lobes.size()> wants_user_{};
    std::size_t lobe_count_ = 0;
    std::int32_t first_medium_label_ = 0;
    bool any_ = false, prunes_ = true, passes_cutouts_ = false, emits_ = false;
    // Materials that scatter by the same lobes are of one kind: a scene has thousands of labels and of materials, and
    // few kinds. 0 is no material.
    std::vector<std::uint32_t> kind_of_;  // [material + 1]
    struct Row {
        std::uint32_t begin, count, with_density;  // in by_kind_; those with a density come first
    };
    [[nodiscard]] const Row& row_of(std::int32_t label, std::int32_t material) const {
        return rows_[static_cast<std::size_t>(label) * kinds_ + kind_of_[static_cast<std::size_t>(material + 1)]];
    }
    std::vector<Row> rows_;  // [label][kind]
    std::vector<lpe::EventClass> by_kind_;
    // Scatterings by materials of objects that have them, and by media that scatter.
    std::vector<lpe::EventClass> in_use_, in_use_with_density_;
    std::size_t kinds_ = 0;
    display::Liveness liveness_;
};

/// Appends the lobes by which paths leave a material: its own lobes and, if closures are regularized (a trait of the
/// integrator), the glossy lobes that replace specular ones.
void append_lobes(const Material& material, bool regularizes, std::vector<LobeId>& lobes);
/// Every event that EventTable can classify and that this scene can produce: the columns of a path atlas.
std::vector<lpe::Event> scene_events(const SceneView& scene, const lpe::LobeSlots& slots, bool regularizes);

/// Makes events, as EventTable classifies them and scene_alphabet() lists them.
lpe::Event scattering_event(const std::string& object_label, const LobeKind& lobe, const lpe::LobeSlots& slots);
lpe::Event straight_event(const std::string& object_label);
lpe::Event phase_event(const std::string& medium_name);
lpe::Event emission_event();
lpe::Event terminal_event(bool infinite, const std::string& light_group);
lpe::Event user_event(const std::string& object_label, UserLobe lobe, const lpe::LobeSlots& slots);

}  // namespace raylex::transport
