// Subpaths from the lights, one a row, side by side: a light and a ray leaving it are drawn by emitted power, then the ray
// goes from surface to surface.
//
//     subpaths.begin(samplers, counters);
//     while (subpaths.going()) {
//         subpaths.advance(samplers, counters, display);   // vertices() are the next of all subpaths that go on
//         ...                                              // what an integrator does with them
//         subpaths.scatter(samplers, counters, invalid);   // called with the row of a power that is no number
//     }
#pragma once

#include <span>
#include <vector>

#include "transport/paths/counters.h"
#include "transport/paths/scattering.h"
#include "transport/paths/strategies.h"
#include "transport/paths/vertex.h"
#include "transport/paths/words.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

struct LightSubpathOptions {
    std::uint32_t max_depth = 5;  ///< scattering events of a whole path, the join's among them
    bool roulette = true;
    bool words = false;           ///< keep the events, for channels
    bool densities = false;       ///< keep sums()
    LightChoice sampled_by = LightChoice::mis;  ///< how camera subpaths sample lights, for sums()
};

struct LightSubpath {
    Rgb power;                  ///< that it brings to its next vertex
    float start_power = 0;      ///< largest colour of it when it left the light: roulette goes by what is left of that
    std::uint32_t light = 0;
    std::uint32_t depth = 0;    ///< scattering events so far
    std::uint32_t segment = 0;  ///< rays so far, those beyond cutouts included
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
/// Of a vertex after `depth` scattering events.
inline std::uint32_t light_subpath_dimension(std::uint32_t depth, LightVertexDimension which) {
    return light_dimensions + first_vertex_dimension + depth * light_stride + which;
}

class LightSubpaths {
  public:
    LightSubpaths(const SceneView& scene, const LightSubpathOptions& options, std::size_t capacity);

    void begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters);
    [[nodiscard]] bool going() const { return queue_.count > 0; }
    /// Traces all rays; what passes cutouts is traced by the next call.
    void advance(std::span<const PixelSampler> samplers, IntegratorCounters& counters, display::DisplayServices& display);
    template <class Invalid>
    void scatter(std::span<const PixelSampler> samplers, IntegratorCounters& counters, Invalid invalid) {
        for (std::size_t j = 0; j < vertices_.count; ++j)
            if (!scatter(j, samplers, counters)) invalid(vertices_.rows[j], paths_[vertices_.rows[j]].power);
    }

    [[nodiscard]] const VertexBatch& vertices() const { return vertices_; }
    [[nodiscard]] const LightSubpath& path(std::uint32_t row) const { return paths_[row]; }
    /// The events before the current vertex, from the light; empty without options.words.
    [[nodiscard]] const std::vector<WordEvent>& word(std::uint32_t row) const { return words_[row]; }
    /// At the current vertex; options.densities only.
    [[nodiscard]] const StrategySums& sums(std::uint32_t row) const { return densities_[row].sums; }

  private:
    /// What the densities of a subpath's next vertex follow from.
    struct Densities {
        StrategySums sums;
        LightSample origin;         // where it left the light
        Vec3 from;                  // its last vertex
        float cosine = 1;           // there, to the direction it left in
        float pdf = 0;              // of that direction, per steradian; from a light at infinity per area
        bool at_light = true, from_infinity = false;
    };
    void begin_densities(std::uint32_t row, const EmissionSample& sample);
    void arrive(std::uint32_t row, const SurfacePoint& point);
    bool passes_cutout(std::size_t j, const PixelSampler& sampler);
    /// False: the power is no number.
    bool scatter(std::size_t j, std::span<const PixelSampler> samplers, IntegratorCounters& counters);
    bool survives_roulette(LightSubpath& path, const PixelSampler& sampler, std::uint32_t dimension) const;

    const SceneView scene_;
    LightSubpathOptions options_;
    std::vector<LightSubpath> paths_;               // by row
    std::vector<std::vector<WordEvent>> words_;     // by row
    std::vector<Densities> densities_;              // by row
    RayQueue queue_;
    VertexBatch vertices_;
};

}  // namespace raylex::transport
