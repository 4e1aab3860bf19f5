// Per-thread state of the light tracer: private to light_tracer*.cpp.
#pragma once

#include <memory>
#include <vector>

#include "transport/integrators/light_tracer.h"
#include "transport/integrators/path.h"
#include "transport/render/camera.h"

namespace raylex::transport {

/// What a light path carries from vertex to vertex.
struct LightPath {
    Rgb power;                  ///< that it brings to its next vertex
    float start_power = 0;      ///< largest colour of it when it left the light: roulette goes by what is left of that
    std::uint32_t light = 0;
    std::uint32_t depth = 0;    ///< scattering events so far
    std::uint32_t segment = 0;  ///< rays so far, those beyond cutouts included
};

/// One event of a light path's word. Straight events have no lobes.
struct WordEvent {
    std::int32_t label = 0;
    bool straight = false;
    LobeList lobes;
};

/// A vertex on its way to be tested for what stands between it and the camera.
struct PendingSplat {
    std::uint32_t row = 0;
    std::int32_t label = 0;
    float x = 0, y = 0;
    Rgb value;
    LobeList lobes;
};

/// Sampler dimensions, far above those of the camera's part: of the emission, then `light_stride` of each vertex.
inline constexpr std::uint32_t light_dimensions = 1u << 26, light_cutout_dimensions = 1u << 27;
enum EmissionDimension : std::uint32_t { emitter_dimension, origin_dimension, direction_dimension, first_vertex_dimension = 8 };
enum LightVertexDimension : std::uint32_t {
    camera_lens_dimension,
    light_scatter_dimension,
    light_lobe_dimension,
    light_roulette_dimension,
    light_key_dimension,
    light_stride
};
inline std::uint32_t dimension(const LightPath& path, LightVertexDimension which) {
    return light_dimensions + first_vertex_dimension + path.depth * light_stride + which;
}

struct LightThread final : IntegratorThread {
    LightThread(std::size_t capacity, std::size_t length_slots) {
        paths.resize(capacity);
        words.resize(capacity);
        next_rows.resize(capacity);
        next_rays.resize(capacity);
        rows.resize(capacity);
        rays.resize(capacity);
        hits.resize(capacity);
        points.resize(capacity);
        sources.resize(capacity);
        bsdfs.resize(capacity);
        pending.resize(capacity);
        shadow_rays.resize(capacity);
        blocked.resize(capacity);
        counters.path_lengths.assign(length_slots, 0);
    }

    // By row.
    std::vector<LightPath> paths;
    std::vector<std::vector<WordEvent>> words;   // from the light; empty when no channel reads words
    // Rays of the next vertex.
    std::vector<std::uint32_t> next_rows;
    std::vector<Ray> next_rays;
    std::size_t next_count = 0;
    // Surface hits of the current vertex, compact.
    std::vector<std::uint32_t> rows;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points;
    std::vector<SurfaceSource> sources;
    std::vector<Bsdf> bsdfs;
    std::size_t count = 0;
    // Connections of this vertex.
    std::vector<PendingSplat> pending;
    std::vector<Ray> shadow_rays;
    std::vector<std::uint8_t> blocked;
    std::size_t pending_count = 0;
    std::unique_ptr<IntegratorThread> camera;    // of the camera rays' part

    void finish(std::uint32_t row) {
        const std::size_t last = counters.path_lengths.size() - 1;
        ++counters.path_lengths[paths[row].depth < last ? paths[row].depth : last];
    }
    void push_next(std::uint32_t row, const Ray& ray) {
        next_rows[next_count] = row;
        next_rays[next_count++] = ray;
    }
    void keep(std::size_t from, std::size_t to) {
        if (from == to) return;
        rows[to] = rows[from];
        rays[to] = rays[from];
        hits[to] = hits[from];
        points[to] = points[from];
        sources[to] = sources[from];
    }
};

class LightTracer final : public Integrator {
  public:
    explicit LightTracer(const LightTracerParameters& parameters);
    [[nodiscard]] IntegratorTraits traits() const override;
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::vector<std::string> omissions() const override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    void emit(const CameraBatch& batch, LightThread& thread) const;
    /// Traces next_rays; hits become the vertex, less what passes straight through cutouts.
    void trace(const CameraBatch& batch, LightThread& thread) const;
    bool passes(const CameraBatch& batch, LightThread& thread, std::size_t j) const;
    void scatter(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const;
    /// False: the path is finished.
    bool goes_on(const CameraBatch& batch, LightThread& thread, ThreadServices& services, std::uint32_t row,
                 std::uint32_t roulette) const;
    // light_tracer_camera.cpp
    void connect(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const;
    void add_splats(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const;
    /// From behind the cutouts next to the camera to the light.
    void read_word(display::Tracker& tracker, display::LpeServices& lpe, const LightThread& thread,
                   const PendingSplat& splat) const;

    LightTracerParameters parameters_;
    IntegratorContext context_;
    std::unique_ptr<Integrator> camera_;   // what camera rays find by themselves
    bool can_emit_ = false, reads_words_ = false;
};

}  // namespace raylex::transport
