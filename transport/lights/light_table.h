// All lights of a scene: choosing one, sampling it, and the density of that for a direction found by scattering.
//
// Sampling and density must agree: every result of sample() has density() > 0, and a light that is never chosen has
// density 0, so that the power heuristic gives its scattering hits the full weight.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "transport/embree/embree_scene.h"
#include "transport/lights/images/emission_image.h"
#include "transport/lights/images/environment.h"
#include "transport/lights/images/intensity_image.h"
#include "transport/lights/images/portal_image.h"
#include "transport/lights/light.h"
#include "transport/lights/light_chooser.h"
#include "transport/lights/stretched_spot.h"

namespace raylex::transport {

/// Lists by kind of light; Light::image is an index into one of these.
struct LightImages {
    std::vector<EnvironmentImage> environments;
    std::vector<PortalImage> portals;
    std::vector<IntensityImage> intensities;
    std::vector<StretchedSpot> spots;  ///< spots whose transform does not keep angles
    std::vector<EmissionImage> emissions;
    std::vector<EmissionPoints> points;  ///< for area lights: one per primitive with an image
};

/// The inputs of a light's factory, and the lists to which it adds.
struct LightContext {
    const SceneDescription& scene;
    LightImages& images;
    std::vector<Error>& warnings;
    RenderSpace space{};  ///< the target space of the light's to_world
};
/// A factory of lights. The light's to_world leads to the space in which EmbreeScene places everything.
using LightFactory = std::function<Result<Light>(const SceneLight&, LightContext&)>;
/// The registered lights: point, spot, goniometric, projection, distant, infinite. Plugins make theirs from the same
/// kinds.
Registry<LightFactory>& light_registry();

/// The emission that an AreaLightSource gives to each primitive of its shapes.
struct AreaEmission {
    Rgb radiance;
    bool two_sided = false;
    std::int32_t image = -1;  ///< index in LightImages::emissions; the radiance is a factor on it
    double power = 0;         ///< of each primitive; 0: the power of its radiance
};
using AreaLightFactory = std::function<Result<AreaEmission>(const SceneAreaLight&, LightContext&)>;
/// The registered area lights: diffuse, and those of plugins.
Registry<AreaLightFactory>& area_light_registry();

class LightTable {
  public:
    /// Builds all lights and sets the shapes' `first_light`.
    static Result<LightTable> build(const SceneDescription& scene, EmbreeScene& geometry, std::vector<Error>& warnings);

    /// A chooser among all lights.
    [[nodiscard]] const LightChooser& chooser(LightChoice choice) const {
        return choosers_[static_cast<std::size_t>(choice)];
    }
    /// Samples a light; returns false if no light can arrive at `from`. u in [0, 1)^2; u_choice in [0, 1), read only if
    /// chooser.needs_number().
    bool sample(const LightChooser& chooser, const EmbreeScene& geometry, const LightReceiver& from, Real u_choice,
                Vec2 u, LightSample& sample) const;
    /// Draws the start and direction of emission: first a light, then for an area light a point and a cosine-weighted
    /// direction, for a point or spot light a direction, for an infinite light a direction and a point of the disk
    /// across it that covers the scene. Returns false if nothing is emitted. All u in [0, 1); u_choice is read only if
    /// chooser.needs_number(). The chooser must not use receivers.
    bool sample_emission(const LightChooser& chooser, const EmbreeScene& geometry, Real u_choice, Vec2 u_position,
                         Vec2 u_direction, EmissionSample& sample) const;
    /// The density with which sample_emission() emits in `direction` from `at` (target, target_normal and uv). For
    /// infinite lights: emits along the ray that comes from `direction`.
    [[nodiscard]] EmissionDensity emission_density(const LightChooser& chooser, const EmbreeScene& geometry,
                                                   const LightSample& at, const Vec3& direction) const;
    /// An arbitrary, fixed point of an area light.
    [[nodiscard]] Vec3 some_point(const EmbreeScene& geometry, std::uint32_t light) const;
    /// Whether a ray can hit any light; if not, a path's last scattering need not be traced.
    [[nodiscard]] bool any_to_hit() const { return any_to_hit_; }

    /// The density with which sample() finds the point `at` (hit by `hit`) of an area light from `from`.
    [[nodiscard]] Real density(const LightChooser& chooser, const EmbreeScene& geometry, std::uint32_t light,
                               const LightReceiver& from, const SurfacePoint& at, const Hit& hit) const;
    /// The density with which sample() finds `at` (target, target_normal, uv; for infinite lights wi) from `from`, per
    /// steradian. For lights that no ray hits: as in LightSample::pdf.
    [[nodiscard]] Real density(const LightChooser& chooser, const EmbreeScene& geometry, const LightReceiver& from,
                               const LightSample& at) const;
    [[nodiscard]] Real environment_density(const LightChooser& chooser, std::uint32_t light, const Vec3& from,
                                           const Vec3& direction) const;

    /// The radiance that an area light emits at a point of it towards `wo`.
    [[nodiscard]] Rgb emitted(std::uint32_t light, const SurfacePoint& at, const Vec3& wo) const {
        const Light& l = lights_[light];
        if (!(l.two_sided || dot(at.geometric_normal, wo) > 0)) return {};
        return l.image < 0 ? l.emission : l.emission * shown(l).radiance(at.u, at.v);
    }
    /// The emission of the light of a sample towards `from`, before distance attenuates it: radiance of lights with an
    /// extent, else intensity, or irradiance across the beam of distant lights.
    [[nodiscard]] Rgb emitted(const LightSample& sample, const Vec3& from) const {
        const bool point = !lights_[sample.light].is_area() && !sample.infinite;
        return point ? sample.radiance * length_squared(sample.target - from) : sample.radiance;
    }
    /// The radiance of an infinite light from a unit direction.
    [[nodiscard]] Rgb environment_radiance(std::uint32_t light, const Vec3& from, const Vec3& direction) const;

    [[nodiscard]] std::span<const Light> lights() const { return lights_; }
    [[nodiscard]] std::span<const std::uint32_t> environments() const { return environment_lights_; }
    /// All light groups in use; [0] is the empty group.
    [[nodiscard]] const std::vector<std::string>& groups() const { return groups_; }

  private:
    /// Calls the sample_*_point() of area_points.h for this kind of area light; its image draws `u`.
    Real sample_area_point(const EmbreeScene& geometry, const Light& light, Vec2 u, LightSample& s) const;
    static Real sample_plain_point(const EmbreeScene& geometry, const Light& light, const Vec2& u, LightSample& s);
    /// The image value of an area light whose primitive is hit at `at`, and the density with which the image draws the
    /// numbers of that point.
    [[nodiscard]] Rgb shown_at(const Light& light, const EmbreeScene& geometry, const Vec2& at) const;
    [[nodiscard]] Real image_density(const Light& light, const ShapeGeometry& shape, const Vec2& at) const;
    [[nodiscard]] const EmissionImage& shown(const Light& light) const {
        return images_.emissions[static_cast<std::size_t>(images_.points[static_cast<std::size_t>(light.image)].image)];
    }
    [[nodiscard]] const IntensityImage& intensity_of(const Light& light) const {
        return images_.intensities[static_cast<std::size_t>(light.image)];
    }
    [[nodiscard]] const StretchedSpot& stretched_spot(const Light& light) const {
        return images_.spots[static_cast<std::size_t>(light.image)];
    }
    [[nodiscard]] const PortalImage& portal_of(const Light& light) const {
        return images_.portals[static_cast<std::size_t>(light.image)];
    }
    [[nodiscard]] const EnvironmentImage& environment_of(const Light& light) const {
        return images_.environments[static_cast<std::size_t>(light.image)];
    }
    bool sample_image_light(const Light& light, const EmbreeScene& geometry, const Vec3& from, const Vec2& u,
                            LightSample& s) const;
    bool sample_infinite(const LightChooser& chooser, const Light& light, const Vec3& from, const Vec2& u,
                         LightSample& s) const;
    bool sample_at_point(const Light& light, const Vec3& from, LightSample& s) const;
    bool emit_from_point(const Light& light, const Vec2& u, EmissionSample& s) const;
    bool emit_through_portal(const Light& light, const EmbreeScene& geometry, const Vec2& u_position,
                             const Vec2& u_direction, EmissionSample& s) const;
    Status add_area_lights(const SceneDescription& scene, EmbreeScene& geometry, LightContext& context,
                           std::vector<Error>& warnings);
    void set_emission(const AreaEmission& emission, const ShapeGeometry& shape, Light& light);
    void finish(const EmbreeScene& geometry);
    std::int32_t group_index(const std::string& group);
    std::vector<Light> lights_;
    std::vector<std::uint32_t> environment_lights_;
    LightImages images_;
    std::vector<std::string> groups_{std::string()};
    std::array<LightChooser, light_choices> choosers_;  ///< [LightChoice]
    bool any_to_hit_ = false;
};

}  // namespace raylex::transport
