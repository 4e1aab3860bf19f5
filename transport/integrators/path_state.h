// Per-thread state of the path integrator: private to path*.cpp.
#pragma once

#include <vector>

#include "transport/integrators/path.h"

namespace raylex::transport {

/// What a path carries from vertex to vertex.
struct PathState {
    Rgb beta{1};                ///< product of scattering weights
    float eta_scale = 1;        ///< product of eta^2 over transmissions: takes their radiance scaling out of roulette
    float scatter_pdf = 0;      ///< density of the last direction, for its MIS weight
    Vec3 from;                  ///< the vertex it left
    float travelled = 0;        ///< along the camera ray, over cutouts passed
    std::uint32_t depth = 0;    ///< scattering events so far
    std::uint32_t segment = 0;  ///< rays so far, those beyond cutouts included: keys the cutouts' choices
    bool certain = true;        ///< the last direction could not have been light-sampled (camera, delta lobes)
};

/// A light sample on its way to be tested for occlusion.
struct PendingLight {
    std::uint32_t row = 0, light = 0;
    std::int32_t label = 0;
    Rgb value;  ///< what arrives at the camera if nothing is in between
    LobeList lobes;
};

/// Surface hits of the current vertex, compact: entry j of every array is one path.
struct VertexBatch {
    std::vector<std::uint32_t> rows;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points;
    std::vector<SurfaceSource> sources;
    std::vector<Bsdf> bsdfs;
    std::size_t count = 0;

    void reserve(std::size_t n) {
        rows.resize(n);
        rays.resize(n);
        hits.resize(n);
        points.resize(n);
        sources.resize(n);
        bsdfs.resize(n);
    }
    /// Entry `from` moves to `to` (before materials have run).
    void keep(std::size_t from, std::size_t to) {
        if (from == to) return;
        rows[to] = rows[from];
        rays[to] = rays[from];
        hits[to] = hits[from];
        points[to] = points[from];
        sources[to] = sources[from];
    }
};

struct PathThread final : IntegratorThread {
    PathThread(std::size_t capacity, std::size_t length_slots) {
        paths.resize(capacity);
        trackers.resize(capacity);
        samplers.resize(capacity);
        next_rows.resize(capacity);
        next_rays.resize(capacity);
        vertices.reserve(capacity);
        pending.resize(capacity);
        emitters.resize(capacity);
        shadow_rays.resize(capacity);
        blocked.resize(capacity);
        counters.path_lengths.assign(length_slots, 0);
    }

    // By row.
    std::vector<PathState> paths;
    std::vector<display::Tracker> trackers;
    std::vector<PixelSampler> samplers;
    // Rays of the next vertex.
    std::vector<std::uint32_t> next_rows;
    std::vector<Ray> next_rays;
    std::size_t next_count = 0;
    VertexBatch vertices;
    // Light samples of this vertex.
    std::vector<PendingLight> pending;
    std::vector<display::EmitterSample> emitters;  // beside pending, where channels ask for them
    std::vector<Ray> shadow_rays;
    std::vector<std::uint8_t> blocked;
    std::size_t pending_count = 0;
    geoaovs::ShadingBatch first_hits;

    void finish(std::uint32_t row) {
        const std::size_t last = counters.path_lengths.size() - 1;
        ++counters.path_lengths[paths[row].depth < last ? paths[row].depth : last];
    }
    void push_next(std::uint32_t row, const Ray& ray) {
        next_rows[next_count] = row;
        next_rays[next_count++] = ray;
    }
};

class PathIntegrator final : public Integrator {
  public:
    explicit PathIntegrator(const PathParameters& parameters) : parameters_(parameters) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        return {true, parameters_.strategy != PathStrategy::scattering, true, true, parameters_.max_depth};
    }
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    void start(const CameraBatch& batch, PathThread& thread, ThreadServices& services) const;
    /// Traces next_rays; misses go to the infinite lights, hits become the vertex batch.
    void trace(PathThread& thread, ThreadServices& services) const;
    void escape(PathThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray) const;
    /// Drops from the batch what passes straight through, adds emission, ends paths at full depth.
    void resolve(PathThread& thread, ThreadServices& services) const;
    bool passes(PathThread& thread, ThreadServices& services, std::size_t j) const;
    void emit(PathThread& thread, ThreadServices& services, std::size_t j) const;
    void record_first_hit(PathThread& thread, ThreadServices& services, std::size_t j) const;
    /// Whether anything is to be learnt at a vertex: of what scatters there, or of the surface itself.
    [[nodiscard]] bool worth_shading(const PathState& path, const display::Tracker& tracker,
                                     const display::LpeServices& lpe) const;
    void write_aovs(PathThread& thread, ThreadServices& services) const;
    void report_surfaces(PathThread& thread, ThreadServices& services) const;
    /// The infinite lights that light sampling leaves to scattering, from which the vertex hides them.
    void report_hidden_environments(PathThread& thread, ThreadServices& services, std::size_t j) const;
    void sample_lights(PathThread& thread, ThreadServices& services) const;
    /// What an emitter with a cutout keeps at the sampled point: as much as scattering finds there on average.
    [[nodiscard]] float emitter_opacity(const LightSample& sample, const Vec3& from) const;
    void add_lights(PathThread& thread, ThreadServices& services) const;
    /// What the cutouts along an otherwise free shadow ray let through; moves `tracker` past them.
    float straight_transmittance(Ray ray, display::Tracker& tracker, ThreadServices& services,
                                 IntegratorCounters& counters) const;
    void scatter(PathThread& thread, ThreadServices& services) const;
    void move(display::Tracker& tracker, display::LpeServices& lpe, std::int32_t label, const LobeList& lobes) const;
    /// An emitter found by scattering, whose light-sampling density is `light_pdf`.
    void deliver(PathThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted, float light_pdf,
                 std::uint32_t light) const;

    [[nodiscard]] LightChoice choice() const {
        return parameters_.strategy == PathStrategy::light ? LightChoice::light_sampling : LightChoice::mis;
    }
    /// Whether light sampling finds the emitter there too, and the weight that is left to scattering.
    [[nodiscard]] bool sampled_too(const PathState& path, float light_pdf) const {
        return !path.certain && light_pdf > 0 && parameters_.strategy != PathStrategy::scattering;
    }
    [[nodiscard]] float scattering_weight(const PathState& path, float light_pdf) const;

    PathParameters parameters_;
    IntegratorContext context_;
    bool can_sample_lights_ = false, reports_surfaces_ = false;
};

}  // namespace raylex::transport
