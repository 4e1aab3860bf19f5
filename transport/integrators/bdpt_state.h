// Per-thread state of bidirectional path tracing: private to bdpt*.cpp.
#pragma once

#include <vector>

#include "transport/integrators/bdpt.h"
#include "transport/paths/camera_connections.h"
#include "transport/paths/light_subpaths.h"

namespace raylex::transport {

/// What a camera subpath carries from vertex to vertex.
struct CameraSubpath {
    Rgb beta{1};                ///< product of scattering weights
    float eta_scale = 1;        ///< product of eta^2 over transmissions: takes their radiance scaling out of roulette
    float travelled = 0;        ///< along the camera ray, over cutouts passed
    Vec3 from;                  ///< the vertex it left, or the camera
    float pdf = 0;              ///< of the direction it left in, per steradian
    float cosine = 1;           ///< of that to the geometric normal there
    std::uint32_t depth = 0;    ///< scattering events so far
    std::uint32_t segment = 0;  ///< rays so far, those beyond cutouts included
    StrategySums sums;
};

/// A light subpath's vertex that camera subpaths are joined with.
struct LightVertex {
    static constexpr std::uint32_t none = 0xffffffffu;
    SurfacePoint point;
    Bsdf bsdf;
    float offset = 0;               ///< SurfaceSource::offset
    std::int32_t label = 0;
    std::uint32_t row = 0, light = 0, depth = 0;
    std::uint32_t word_length = 0;  ///< events before it
    std::uint32_t previous = none;  ///< of the same subpath
    Rgb power;
    StrategySums sums;
};

/// A light sample or a join that waits for its shadow ray.
struct Join {
    std::uint32_t row = 0;
    std::uint32_t vertex = LightVertex::none;   ///< of the light subpath; none: a light sample
    std::uint32_t light = 0;
    std::int32_t label = 0;         ///< of the camera subpath's vertex
    Rgb value;
    LobeList lobes, light_lobes;    ///< at the camera subpath's vertex and at the light subpath's
};

// Sampler dimensions of camera vertex k start at first_free_dimension + k * camera_stride.
enum CameraVertexDimension : std::uint32_t {
    camera_choice_dimension,
    camera_light_dimension,
    camera_scatter_dimension,
    camera_lobe_dimension,
    camera_roulette_dimension,
    camera_key_dimension,
    camera_stride
};
inline constexpr std::uint32_t camera_cutout_dimensions = 1u << 24;
inline std::uint32_t camera_dimension(const CameraSubpath& path, CameraVertexDimension which) {
    return first_free_dimension + path.depth * camera_stride + which;
}

struct BdptThread final : IntegratorThread {
    BdptThread(const SceneView& scene, const LightSubpathOptions& options, std::size_t capacity)
        : light(scene, options, capacity), paths(capacity), trackers(capacity), last_vertex(capacity) {
        queue.reserve(capacity);
        vertices.reserve(capacity);
        first_entries.resize(capacity);
        counters.path_lengths.assign(std::min<std::size_t>(options.max_depth, 1024) + 1, 0);
    }

    LightSubpaths light;
    std::vector<LightVertex> light_vertices;    // of all rows
    std::vector<std::pair<std::uint32_t, Rgb>> invalid_powers;   // row, power
    CameraConnections connections;
    // By row.
    std::vector<CameraSubpath> paths;
    std::vector<display::Tracker> trackers;
    std::vector<std::uint32_t> last_vertex;     // in light_vertices
    // The camera subpaths' current vertex.
    RayQueue queue;
    VertexBatch vertices;
    std::vector<Join> joins;
    std::vector<Ray> shadow_rays;
    std::vector<std::uint8_t> blocked;
    // Entries of `vertices` that are the first of their paths.
    std::vector<std::uint32_t> first_entries;
    std::size_t first_count = 0;
    geoaovs::ShadingBatch first_hits;
};

class Bdpt final : public Integrator {
  public:
    explicit Bdpt(const DepthParameters& parameters) : parameters_(parameters) {}
    [[nodiscard]] IntegratorTraits traits() const override;
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    /// False: the batch is to be left.
    bool trace_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    void keep_light_vertices(BdptThread& thread) const;
    void start_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    void trace_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    /// What the rays have met: cutouts, lights, vertices that go on.
    void resolve(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    bool passes_cutout(const CameraBatch& batch, BdptThread& thread, ThreadServices& services, std::size_t j) const;
    void scatter(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    bool survives_roulette(CameraSubpath& path, const PixelSampler& sampler, std::uint32_t dimension) const;
    // bdpt_joins.cpp
    /// Light that the camera subpath has found by itself (s = 0): at a surface, or from infinity.
    void find_light(BdptThread& thread, ThreadServices& services, std::size_t j) const;
    void find_environments(BdptThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray) const;
    void add_found(BdptThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted,
                   const LightSample& at, float sampled, const Vec3& towards) const;
    void sample_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services, std::size_t j) const;
    void join_vertices(BdptThread& thread, ThreadServices& services, std::size_t j) const;
    /// Whether a channel still takes what this join would bring; true with beauty (Law 4).
    bool worth_a_ray(const BdptThread& thread, ThreadServices& services, const Join& join) const;
    void add_joins(BdptThread& thread, ThreadServices& services) const;
    void connect_to_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const;
    [[nodiscard]] std::span<const WordEvent> word_of(const BdptThread& thread, const LightVertex& vertex) const {
        return {thread.light.word(vertex.row).data(), vertex.word_length};
    }

    DepthParameters parameters_;
    IntegratorContext context_;
    CameraView view_;
    bool can_emit_ = false, can_sample_lights_ = false;
};

}  // namespace raylex::transport
