// Per-thread state of bidirectional path tracing: private to bdpt*.cpp.
#pragma once

#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "transport/integrators/methods/bdpt.h"
#include "transport/paths/subpaths/connect.h"
#include "transport/paths/subpaths/light_subpaths.h"
#include "transport/paths/subpaths/live_lights.h"

namespace raylex::transport {

/// A light subpath's vertex that camera subpaths are joined with.
struct LightVertex {
    static constexpr std::uint32_t none = 0xffffffffu;
    SurfacePoint point;
    Bsdf bsdf;
    OffsetBound offset{};              ///< SurfaceSource::offset
    std::uint32_t row = 0, depth = 0;  ///< Subpath's
    VertexDepth length;
    LightEnd end;
    std::uint32_t previous = none;  ///< of the same subpath
    display::LightForesight::Ahead ahead;
    bool holdout = false, one_wavelength = false;
    Rgb power;  ///< Subpath::beta
    StrategySums sums;
};

/// Vertices of a batch's light subpaths wait for camera subpaths. So that they take this much at most, a subpath is cut
/// behind its share of them: some 2,300, bodies of subsurface materials included.
inline constexpr std::size_t light_vertices_budget = std::size_t{256} << 20;

struct BdptThread final : IntegratorThread {
    BdptThread(const SceneView& scene, const EventTable& events, const CameraSubpathOptions& of_camera,
               const LightSubpathOptions& of_light, std::size_t capacity)
        : light(scene, events, of_light, capacity),
          camera(scene, events, of_camera, capacity),
          joins(scene),
          last_vertex(capacity) {
        counters.path_lengths.assign(std::min<std::size_t>(of_camera.walk.max_depth, 1024) + 1, 0);
    }

    LightSubpaths light;
    CameraSubpaths camera;
    Connections joins;  // light samples among them
    CameraConnections splats;
    std::vector<LightVertex> light_vertices;                    // of all rows
    std::vector<std::uint32_t> last_vertex;                     // by row, in light_vertices
    std::vector<std::pair<std::uint32_t, Rgb>> invalid_powers;  // row, power
    geoaovs::ShadingBatch first_hits;
};

class Bdpt final : public Integrator {
  public:
    explicit Bdpt(const BdptParameters& parameters)
        : parameters_(parameters.depth),
          first_depth_(parameters.first_depth),
          count_mirrors_(parameters.count_mirrors) {}
    [[nodiscard]] IntegratorTraits traits() const override;
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    [[nodiscard]] std::vector<std::string> cuts() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    /// False: the batch is to be left.
    bool trace_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    void keep_light_vertices(BdptThread& thread) const;
    // bdpt_joins.cpp
    struct Ends;
    void sample_light(BdptThread& thread, std::size_t j, const display::Foresight::Ahead& ahead) const;
    void join_vertices(BdptThread& thread, std::size_t j) const;
    void connect_to_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    /// What all strategies beside a light sample weigh, as a share of it.
    [[nodiscard]] StrategySums::Wide others_beside_light_sample(const BdptThread& thread, std::size_t j,
                                                                const LightSample& sample,
                                                                const JoinedScattering& f) const;

    DepthParameters parameters_;
    std::uint32_t first_depth_ = 0, most_scatterings_ = 0;
    bool count_mirrors_ = true;
    mutable std::atomic<std::uint64_t> cut_light_paths_{0};
    IntegratorContext context_;
    CameraView view_;
    std::vector<std::int32_t> media_of_lights_;
    std::optional<LightLanguage> language_;  // when channels read words
    LightChooser emitters_, sampled_;        // where light subpaths begin, and light samples go: live lights
    std::uint64_t sampled_terminals_ = 0;    // Foresight's bits of those
    bool can_emit_ = false, can_sample_lights_ = false;
    bool not_begun_ = false;   // light subpaths, which no word asks for
    bool none_joins_ = false;  // light samples could be drawn, and no word asks for any
};

/// Light that camera subpaths have found by themselves (s = 0).
struct Bdpt::Ends : CameraEnds {
    const Bdpt& self;
    CameraSubpaths& camera;

    void emits(std::size_t j);
    void arrives(std::size_t j) {
        if (camera.record().wants_blocked_light()) camera.report_hidden_environments(self.sampled_, j);
    }
    void escapes(std::uint32_t row, const Ray& ray);
    void volume_emits(std::uint32_t row, const Rgb& emitted);
    /// `sampled`: the density with which a light sample would have found it; light leaves `at` in the direction
    /// `towards`.
    void add(std::uint32_t row, const Rgb& emitted, const LightSample& at, Real sampled, const Vec3& towards);
};

}  // namespace raylex::transport
