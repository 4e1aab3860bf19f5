// Radiance found later: what each vertex of a path leads to.
//
// Light is reported at the vertex where a path finds it. Code that learns from paths (pilots, a guide) needs it at the
// earlier vertices of the path. So the walk reports each vertex that a path leaves. All light that the channels receive
// for the row after that belongs to the vertex, until the path ends or goes back to a vertex that is as near to the
// camera (splits.h). Values come from the sample table, so only light that a channel takes is included.
//
//     later.begin();
//     services.later = &later;
//     integrator.integrate(batch, thread, services);
//     later.end(batch.rays.size(), [&](std::size_t row, const LaterRadiance::Path& path) { ... });
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/sample_table.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// A vertex of a camera subpath, as a ray leaves it.
struct PassedVertex {
    std::uint32_t row = 0;
    std::uint32_t depth = 0;  ///< number of scattering events, with this one
    std::uint64_t state = 0;  ///< state of the path's tracker, by which a plan distinguishes paths
    Rgb throughput;           ///< includes the scattering here; each ray of a split vertex carries its part of it
    Real reached = 0;         ///< mean colour of the throughput with which the path arrived
    /// Mean colour of the throughput with which the path arrived, times the factors that roulette and splits have given
    /// the ray.
    Real arrived = 0;
    Real strength = 0;   ///< the value that roulette compares: the largest colour, without the scaling by eta^2
    bool split = false;  ///< rays are split at this vertex or before
    bool emits = false;  ///< the vertex is on an emitter
    /// The vertex' closure has a density that a sampler of directions may change.
    bool guidable = false;
    bool specular = false;  ///< the direction is that of a specular lobe
    Vec3 position, direction;
    Vec3 normal;      ///< shading normal; zero in a medium
    Real chance = 0;  ///< density of the direction per steradian, or the probability of its specular lobe
    /// Density of the direction per steradian, times the expected number of rays that leave the vertex by the plan. For
    /// a specular direction: the probability of its lobe.
    Real pdf = 0;
};

/// Records the vertices of paths and the light that channels receive behind them; for one thread.
class LaterRadiance {
  public:
    /// The vertices of one row's path, and the values that `channels` received: each value is the mean of three
    /// colours.
    struct Path {
        std::span<const PassedVertex> vertices;  ///< in the order in which rays left them
        std::size_t channels = 0;
        const double *before_vertices, *behind_vertices;  // [vertex][channel]
        const double* received;                           ///< [channel] from the whole path

        /// The value that the channel had received when the ray left vertex i; it includes the light sample at the
        /// vertex.
        [[nodiscard]] double before(std::size_t i, std::size_t channel) const {
            return before_vertices[i * channels + channel];
        }
        /// The value that the channel received behind vertex i. Divided by the ray's throughput, it is the radiance
        /// along the ray.
        [[nodiscard]] double behind(std::size_t i, std::size_t channel) const {
            return behind_vertices[i * channels + channel];
        }
    };

    /// Expression channels of `table`, which must outlive the object.
    LaterRadiance(const display::SampleTable& table, std::vector<display::ChannelId> channels)
        : table_(table), channels_(std::move(channels)) {}
    [[nodiscard]] const std::vector<display::ChannelId>& channels() const { return channels_; }

    /// A new batch: forgets all vertices.
    void begin();
    void pass(const PassedVertex& vertex);
    /// All paths of the batch have ended. Calls visit(row, path) for each row in [0, rows).
    template <class Visit>
    void end(std::size_t rows, Visit visit) {
        sort_by_row();
        for (std::size_t row = 0, first = 0; row < rows; ++row) {
            const Path path = path_of(row, first);
            first += path.vertices.size();
            visit(row, path);
        }
    }

  private:
    [[nodiscard]] double received(std::size_t channel, std::size_t row) const;
    void sort_by_row();
    [[nodiscard]] Path path_of(std::size_t row, std::size_t first);

    const display::SampleTable& table_;
    std::vector<display::ChannelId> channels_;
    std::vector<PassedVertex> vertices_;
    std::vector<double> before_, behind_, received_;  // [vertex][channel]; received_: [channel] of a row
};

}  // namespace raylex::transport
