// Splitting (Arvo and Kirk 1990, "Particle Transport and Image Synthesis"): several rays leave one vertex, each with
// its part of the throughput. It pays where most noise comes from behind the vertex and most cost from before it.
//
// The same row follows the branches one after another. A copy of a split vertex is kept. When no subpath of the batch
// goes on any more, subpaths go back to the copies made last. So the order in which a sample reports light depends on
// that sample alone (Law 3), and a batch takes no more memory.
#pragma once

#include <cstdint>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "transport/paths/plan/path_plan.h"
#include "transport/paths/subpath.h"
#include "transport/paths/vertex.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// The number that chooses the first (branch 0) or the last of a closure's lobes.
inline Real lobe_number(std::uint32_t branch) {
    return branch == 0 ? Real(0) : Real(1 - 0x1p-24);
}

/// Copies of split vertices, entry by entry as they were before the first ray left them.
struct SplitVertices {
    VertexBatch vertices;
    std::vector<Subpath> paths;
    std::vector<SplitState> splits;
    std::vector<TechniqueShares> shares;
    std::vector<display::Tracker> trackers;
    std::vector<PixelSampler> samplers;
    std::uint32_t next = 0;  ///< branch

    explicit SplitVertices(std::size_t capacity)
        : paths(capacity), splits(capacity), shares(capacity), trackers(capacity), samplers(capacity) {
        vertices.reserve(capacity);
    }
    /// Drops vertices that have no branch left.
    void drop_finished();
};

}  // namespace raylex::transport
