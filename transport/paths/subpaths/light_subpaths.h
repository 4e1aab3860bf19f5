// Subpaths from the lights, one a row, side by side: a light and a ray leaving it are drawn by emitted power, then the
// ray goes from vertex to vertex.
//
//     subpaths.begin(camera_rays, samplers, lpe, counters);
//     while (subpaths.going()) {
//         subpaths.advance(display);   // vertices() are the next of all subpaths that go on
//         ...                          // what an integrator does with them
//         subpaths.scatter(invalid);   // called with the row of a power that is no number
//     }
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {

struct LightSubpathOptions {
    WalkOptions walk;
    const LightLanguage* language = nullptr;                                     ///< null when no channel reads words
    const LightChooser* emitters = nullptr;                                      ///< where subpaths begin
    std::uint32_t most_scatterings = std::numeric_limits<std::uint32_t>::max();  ///< longer ones are cut there
    const LightChooser* sampled = nullptr;          ///< where camera subpaths sample lights, for sums()
    std::span<const std::int32_t> media_of_lights;  ///< media_of_lights(); all of these must outlive the subpaths
};

class LightSubpaths {
  public:
    LightSubpaths(const SceneView& scene, const EventTable& events, const LightSubpathOptions& options,
                  std::size_t capacity);

    /// Each at the time of the camera ray of its sample. LightEnds of the batch before are no longer good.
    void begin(std::span<const Ray> camera_rays, std::span<const PixelSampler> samplers, display::LpeServices& lpe,
               IntegratorCounters& counters);
    [[nodiscard]] bool going() const { return walk_.going(); }
    /// Traces all rays; what passes cutouts is traced by the next call.
    void advance(display::DisplayServices& display);
    template <class Invalid>
    void scatter(Invalid invalid) {
        Scatterer<Invalid> scatterer{{}, *this, invalid};
        walk_.scatter(scatterer);
    }

    /// How many were cut since the last call (LightSubpathOptions::most_scatterings).
    [[nodiscard]] std::uint64_t take_cut() { return std::exchange(cut_, 0); }
    [[nodiscard]] const VertexBatch& vertices() const { return walk_.vertices(); }
    [[nodiscard]] const Subpath& path(std::uint32_t row) const { return walk_.path(row); }
    [[nodiscard]] const PixelSampler& sampler(std::uint32_t row) const { return walk_.sampler(row); }
    [[nodiscard]] const DepthLimit& depth_limit() const { return walk_.depth_limit(); }
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j) const { return walk_.vertex_depth(j); }
    /// Walk's: the power, and the weight of its wavelength if it is of one.
    [[nodiscard]] Rgb throughput(std::uint32_t row) const { return walk_.throughput(row); }
    /// Of paths that are of one wavelength: its weight.
    [[nodiscard]] const Rgb& wavelength_weight(std::uint32_t row) const { return walk_.wavelengths().weight(row); }
    /// What channels may take of joins at vertex j, and of what is scattered there (Law 4).
    [[nodiscard]] display::LightForesight::Ahead ahead(std::size_t j) const {
        return record_.ahead(vertices().rows[j], vertices().sources[j].label, vertices().points[j].material);
    }
    /// Whether vertex j of a camera subpath may be joined with `end`, where this material is.
    [[nodiscard]] bool worth_joining(const CameraSubpaths& camera, std::size_t j, const LightEnd& end,
                                     std::int32_t material) const {
        const VertexBatch& v = camera.vertices();
        return record_.worth_joining(camera.record(), v.rows[j], v.sources[j].label, v.points[j].material, end,
                                     material);
    }
    /// For joins at vertex j: its lobes are to be filled in.
    [[nodiscard]] LightEnd end(std::size_t j) const {
        return record_.end(vertices().rows[j], vertices().sources[j].label);
    }
    /// At the current vertex; options.walk.densities only.
    [[nodiscard]] const StrategySums& sums(std::uint32_t row) const { return walk_.sums(row); }

  private:
    struct Visitor;
    template <class Invalid>
    struct Scatterer : WalkVisitor {
        LightSubpaths& self;
        Invalid& report;
        /// What scatters no more may still be joined, or be seen by the camera.
        bool worth_scattering(std::size_t j) {
            const bool worth = self.ahead(j).goes_on;
            if (!worth) self.walk_.counters().count(Pruned::light_paths);
            const bool cut = worth && self.path(self.vertices().rows[j]).depth >= self.options_.most_scatterings;
            self.cut_ += cut ? 1 : 0;
            return worth && !cut;
        }
        void scatters(std::size_t j, const LobeList& lobes) {
            const std::uint32_t row = self.vertices().rows[j];
            self.record_.scatter(row, self.vertices().sources[j].label, lobes, self.choice_key(row));
        }
        bool goes_on(std::uint32_t row) { return self.worth(row); }
        void invalid(std::uint32_t row) { report(row, self.path(row).beta); }
    };
    [[nodiscard]] bool worth(std::uint32_t row) {
        const bool worth = record_.worth(row);
        if (!worth) walk_.counters().count(Pruned::light_paths);
        return worth;
    }
    void start(std::uint32_t row, const EmissionSample& sample, Real time);
    [[nodiscard]] Rgb from_infinity(std::uint32_t row, const EmissionSample& sample) const;
    /// For a choice between lobes at the current vertex.
    [[nodiscard]] std::uint64_t choice_key(std::uint32_t row) const {
        using Walk = Walk<TransportMode::importance>;
        return sampler(row).key(Walk::dimensions.of(path(row).depth, Walk::dimensions.key));
    }

    const SceneView scene_;
    const LightSubpathOptions options_;
    Walk<TransportMode::importance> walk_;
    LightRecord record_;
    std::uint64_t cut_ = 0;
    std::vector<LightSample> origins_;  // by row: where it left the light; for densities only
};

}  // namespace raylex::transport
