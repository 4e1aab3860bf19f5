// Per-thread state of the path integrator: private to path*.cpp.
#pragma once

#include <vector>

#include "transport/integrators/path.h"
#include "transport/paths/vertex.h"
#include "transport/paths/words.h"

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
    bool specular_bounce = true;        ///< the last direction could not have been light-sampled (camera, delta lobes)
};

// Sampler dimensions of vertex k start at first_free_dimension + k * stride.
enum VertexDimension : std::uint32_t {
    choice_dimension,
    light_dimension,
    scatter_dimension,
    lobe_dimension,
    roulette_dimension,
    key_dimension,
    stride
};
inline constexpr std::uint32_t cutout_dimensions = 1u << 24;  // one per ray, far above every vertex's
inline constexpr std::uint32_t flight_dimensions = 1u << 25;  // one per ray through a medium

inline std::uint32_t dimension(const PathState& path, VertexDimension which) {
    return first_free_dimension + path.depth * stride + which;
}

/// A light sample on its way to be tested for occlusion.
struct PendingLight {
    std::uint32_t row = 0, light = 0;
    std::int32_t label = 0;
    Rgb value;  ///< what arrives at the camera if nothing is in between
    LobeList lobes;
};

/// Beside a PendingLight, in scenes with media.
struct PendingLightMedia {
    std::int32_t along = -1;       ///< the medium in which the shadow ray begins; -1: none
    std::int32_t scattered = -1;   ///< the medium whose particles are lit; -1: a surface is, by PendingLight's lobes
};

/// Collisions with the particles of a medium at the current vertex: entry j of every array is one path.
struct CollisionBatch {
    std::vector<std::uint32_t> rows;
    std::vector<Vec3> positions, forward;  ///< forward: unit, the way the path came along
    std::size_t count = 0;

    void reserve(std::size_t n) {
        rows.resize(n);
        positions.resize(n);
        forward.resize(n);
    }
    void add(std::uint32_t row, const Vec3& position, const Vec3& direction) {
        rows[count] = row;
        positions[count] = position;
        forward[count++] = direction;
    }
};

struct PathThread final : IntegratorThread {
    PathThread(std::size_t capacity, std::size_t length_slots, bool with_media) {
        paths.resize(capacity);
        trackers.resize(capacity);
        samplers.resize(capacity);
        queue.reserve(capacity);
        vertices.reserve(capacity);
        first_entries.resize(capacity);
        pending.resize(capacity);
        emitters.resize(capacity);
        shadow_rays.resize(capacity);
        blocked.resize(capacity);
        counters.path_lengths.assign(length_slots, 0);
        if (!with_media) return;
        media.resize(capacity);
        light_media.resize(capacity);
        collisions.reserve(capacity);
    }

    // By row.
    std::vector<PathState> paths;
    std::vector<display::Tracker> trackers;
    std::vector<PixelSampler> samplers;
    RayQueue queue;   // of the next vertex
    VertexBatch vertices;
    // Light samples of this vertex.
    std::vector<PendingLight> pending;
    std::vector<display::EmitterSample> emitters;  // beside pending, where channels ask for them
    std::vector<Ray> shadow_rays;
    std::vector<std::uint8_t> blocked;
    std::size_t pending_count = 0;
    // Entries of `vertices` that are the first of their paths.
    std::vector<std::uint32_t> first_entries;
    std::size_t first_count = 0;
    geoaovs::ShadingBatch first_hits;
    // In scenes with media only.
    std::vector<std::int32_t> media;              // by row: what the path's next ray flies through; -1: nothing
    std::vector<PendingLightMedia> light_media;   // beside pending
    CollisionBatch collisions;

    void finish(std::uint32_t row) { counters.count_length(paths[row].depth); }
};

class PathIntegrator final : public Integrator {
  public:
    explicit PathIntegrator(const PathParameters& parameters) : parameters_(parameters) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        return {true, parameters_.strategy != PathStrategy::scattering, true, true, parameters_.max_depth, true,
                SavedState::none};
    }
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;

  private:
    void start(const CameraBatch& batch, PathThread& thread, ThreadServices& services) const;
    /// Misses go to the infinite lights, collisions with particles to the collisions, hits become the vertex batch.
    void trace_rays(PathThread& thread, ThreadServices& services) const;
    void escape(PathThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray) const;
    /// Drops from the batch what passes straight through, adds emission, ends paths at full depth.
    void resolve(PathThread& thread, ThreadServices& services) const;
    bool passes_cutout(PathThread& thread, ThreadServices& services, std::size_t j) const;
    void emit(PathThread& thread, ThreadServices& services, std::size_t j) const;
    /// Whether anything is to be learnt at a vertex: of what scatters there, or of the surface itself.
    [[nodiscard]] bool worth_shading(const PathState& path, const display::Tracker& tracker,
                                     const display::LpeServices& lpe) const;
    void report_surfaces(PathThread& thread, ThreadServices& services) const;
    /// The infinite lights that light sampling leaves to scattering, from which the vertex hides them.
    void report_hidden_environments(PathThread& thread, ThreadServices& services, std::size_t j) const;
    // path_lights.cpp
    void sample_lights(PathThread& thread, ThreadServices& services) const;
    void add_lights(PathThread& thread, ThreadServices& services) const;
    // path_media.cpp; these run only in scenes with media
    /// Takes a path through `medium` to a hit or miss at `distance`; false if it ends or collides before.
    bool cross_medium(PathThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray,
                      std::int32_t medium, float distance) const;
    /// Whether what `medium` scatters could count at all (Law 4).
    [[nodiscard]] bool worth_colliding(const PathState& path, const display::Tracker& tracker, std::int32_t medium,
                                       const display::LpeServices& lpe) const;
    /// Appends light samples for the collisions to those of the surfaces.
    void sample_lights_in_media(PathThread& thread, ThreadServices& services) const;
    void scatter_in_media(PathThread& thread, ThreadServices& services) const;
    // path.cpp
    /// After a scattering: counts throughputs that are no numbers, plays roulette with the number at
    /// `roulette`, and asks whether anything is left to find. False: the path is finished.
    bool goes_on(PathThread& thread, ThreadServices& services, std::uint32_t row, std::uint32_t roulette) const;
    void scatter(PathThread& thread, ThreadServices& services) const;
    /// An emitter found by scattering, whose light-sampling density is `light_pdf`.
    void add_emission(PathThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted,
                      float light_pdf, std::uint32_t light) const;

    [[nodiscard]] LightChoice choice() const {
        const bool all = parameters_.strategy == PathStrategy::light;
        if (parameters_.light_selection == LightSelection::uniform)
            return all ? LightChoice::light_sampling_uniform : LightChoice::mis_uniform;
        return all ? LightChoice::light_sampling : LightChoice::mis;
    }
    /// Whether light sampling finds the emitter there too, and the weight that is left to scattering.
    [[nodiscard]] bool sampled_too(const PathState& path, float light_pdf) const {
        return !path.specular_bounce && light_pdf > 0 && parameters_.strategy != PathStrategy::scattering;
    }
    [[nodiscard]] float scattering_weight(const PathState& path, float light_pdf) const;

    PathParameters parameters_;
    IntegratorContext context_;
    bool can_sample_lights_ = false, reports_surfaces_ = false, in_media_ = false, emitters_can_be_hit_ = false;
};

}  // namespace raylex::transport
