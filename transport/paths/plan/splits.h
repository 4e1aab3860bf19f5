// Splitting (Arvo and Kirk 1990, "Particle Transport and Image Synthesis"): several rays go on from one vertex, each
// carrying its part, where what lies behind it is what is noisy and what lies before it is what costs.
//
// Branches are followed one after another by the same row: a vertex that more rays are to leave is kept as it was, and
// when nothing of the batch goes on any more, subpaths go back to the last ones kept. The order of what one sample
// reports then depends on that sample alone (Law 3), and a batch takes no more room.
#pragma once

#include <cstdint>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "transport/paths/plan/path_plan.h"
#include "transport/paths/subpath.h"
#include "transport/paths/vertex.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// Numbers that choose the first and the last of a closure's lobes.
inline Real lobe_number(std::uint32_t branch) {
    return branch == 0 ? Real(0) : Real(1 - 0x1p-24);
}

/// Vertices that are left again, entry by entry as they were before they were left first.
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
