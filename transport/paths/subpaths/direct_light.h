// Next event estimation: chooses the light that a vertex samples, decides whether it samples one, computes the density,
// and reports blocked light.
//
//     direct_light.sample(camera, connections, weight);
//     connections.report(camera);
#pragma once

#include <memory>

#include "transport/paths/subpaths/connect.h"
#include "transport/paths/subpaths/live_lights.h"

namespace raylex::transport {

/// How emitters are found. `mis` for images. The others estimate the same integral alone, for experiments and tests:
/// `light` leaves area lights to light sampling (emitters seen directly or by delta lobes excepted), `scattering`
/// leaves all but delta lights to scattering.
enum class PathStrategy : std::uint8_t { mis, light, scattering };

/// How a light sample chooses its light: by the light that each one can send to the receiver, where there are many; by
/// emitted power (one choice in ten is uniform); or uniformly.
enum class LightSelection : std::uint8_t { receiver, power, uniform };

LightChoice light_choice(LightSelection selection, PathStrategy strategy);

/// Tables for a whole render, shared by all threads. Every vertex samples among the lights whose light some channel can
/// still accept (Law 4). A sampler of directions, and at last vertices the plan, may decide that a vertex takes none.
class DirectLight {
  public:
    DirectLight() = default;
    /// `context` must outlive the object.
    DirectLight(const PathContext& context, LightSelection selection, PathStrategy strategy);
    /// For bdpt, whose weights need the same choice of lights at every vertex: among the lights that connections may
    /// meet by `language` (null: all).
    DirectLight(const PathContext& context, const LightLanguage* language);

    /// Queues a light sample for every vertex that can be connected with light. `weight(j, sample, f)` is called for
    /// every sample and returns its weight of multiple importance sampling: 1 where no other technique finds that
    /// light. `f` is what vertex j scatters towards the sample. Emitters that the subpaths have met are reported
    /// before: this sets how the vertices look for light (Subpath::lights).
    template <class Weight>
    void sample(CameraSubpaths& camera, Connections& connections, Weight weight) const;
    /// The density, per steradian, with which a light sample from where the subpath was scattered finds the emitter
    /// that the subpath has met; 0 where light sampling does not find it.
    [[nodiscard]] Real density(const CameraSubpaths& camera, const EmitterHit& hit) const;
    /// The density, per steradian, with which a light sample from where the subpath was scattered finds the infinite
    /// light behind the escaped ray; 0 where light sampling does not find it.
    [[nodiscard]] Real density(const CameraSubpaths& camera, const EscapedRay& ray, std::uint32_t light) const;
    /// For channels that take blocked light. If a ray hits a surface, reports with visibility 0 the infinite lights
    /// behind the surface that light samples never find.
    void report_hidden_environments(const CameraSubpaths& camera) const;
    /// The choice among all lights that are sampled.
    [[nodiscard]] const LightChooser& chooser() const { return (*lights_)[LiveLights::all]; }

  private:
    /// Decides whether vertex j takes a light sample, and draws it. Returns false if the vertex takes none. `planned`:
    /// the sampler of directions plans rays.
    bool draw(CameraSubpaths& camera, std::size_t j, bool planned, LightSample& sample) const;

    const PathContext* context_ = nullptr;
    std::shared_ptr<const LiveLights> lights_;
    PathStrategy strategy_ = PathStrategy::mis;
};

template <class Weight>
void DirectLight::sample(CameraSubpaths& camera, Connections& connections, Weight weight) const {
    if (chooser().empty() && !lights_->none_is_live()) return;
    camera.draw_light_pairs();
    const VertexBatch& v = camera.vertices();
    const bool planned = context_->directions != nullptr && context_->directions->plans_rays();
    for (std::size_t j = 0; j < v.count; ++j) {
        LightSample light;
        if (!camera.can_connect(j) || !draw(camera, j, planned, light)) continue;
        const BsdfEvaluation f = evaluate_towards(context_->directions, v.bsdfs[j], v.points[j], light.wi);
        if (!f.value.is_black()) connections.add_light_sample(camera, j, light, f, weight(j, light, f));
    }
}

}  // namespace raylex::transport
