// Subpaths from the lights, one a row, side by side: a light and a ray leaving it are drawn by emitted power, then the ray
// goes from vertex to vertex.
//
//     subpaths.begin(samplers, counters);
//     while (subpaths.going()) {
//         subpaths.advance(display);   // vertices() are the next of all subpaths that go on
//         ...                          // what an integrator does with them
//         subpaths.scatter(invalid);   // called with the row of a power that is no number
//     }
#pragma once

#include <span>
#include <vector>

#include "transport/paths/record.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

struct LightSubpathOptions {
    WalkOptions walk;
    bool events = false;                                   ///< keep them, for channels
    LightChoice camera_samples_by = LightChoice::mis;      ///< how camera subpaths sample lights, for sums()
    std::span<const std::int32_t> media_of_lights;         ///< media_of_lights(); must outlive the subpaths
};

class LightSubpaths {
  public:
    LightSubpaths(const SceneView& scene, const EventTable& events, const LightSubpathOptions& options,
                  std::size_t capacity);

    void begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters);
    [[nodiscard]] bool going() const { return walk_.going(); }
    /// Traces all rays; what passes cutouts is traced by the next call.
    void advance(display::DisplayServices& display);
    template <class Invalid>
    void scatter(Invalid invalid) {
        Scatterer<Invalid> scatterer{{}, *this, invalid};
        walk_.scatter(scatterer);
    }

    [[nodiscard]] const VertexBatch& vertices() const { return walk_.vertices(); }
    [[nodiscard]] const Subpath& path(std::uint32_t row) const { return walk_.path(row); }
    [[nodiscard]] const PixelSampler& sampler(std::uint32_t row) const { return walk_.sampler(row); }
    /// The events before the current vertex, from the light; empty without options.events.
    [[nodiscard]] const std::vector<LightEvent>& events(std::uint32_t row) const { return events_[row]; }
    /// At the current vertex; options.walk.densities only.
    [[nodiscard]] const StrategySums& sums(std::uint32_t row) const { return walk_.sums(row); }

  private:
    struct Visitor;
    template <class Invalid>
    struct Scatterer : WalkVisitor {
        LightSubpaths& self;
        Invalid& report;
        void scatters(std::size_t j, const LobeList& lobes) { self.keep_event(j, {0, false, lobes}); }
        void invalid(std::uint32_t row) { report(row, self.path(row).beta); }
    };
    void start(std::uint32_t row, const EmissionSample& sample);
    void keep_event(std::size_t j, LightEvent event) {
        if (!options_.events) return;
        event.label = vertices().sources[j].label;
        events_[vertices().rows[j]].push_back(event);
    }

    const SceneView scene_;
    const LightSubpathOptions options_;
    Walk<TransportMode::importance> walk_;
    std::vector<std::vector<LightEvent>> events_;   // by row
    std::vector<LightSample> origins_;              // by row: where it left the light; for densities only
};

}  // namespace raylex::transport
