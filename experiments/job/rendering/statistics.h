// Costs and counts of a render as JSON.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/output/splits/split_check.h"
#include "experiments/job/job.h"
#include "experiments/job/text/json.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Wall seconds and CPU seconds (of all threads) of one phase.
struct PhaseTime {
    double wall_seconds = 0, cpu_seconds = 0;
};

/// Measures both times since its construction.
class PhaseClock {
  public:
    PhaseClock();
    [[nodiscard]] PhaseTime elapsed() const;

  private:
    double wall_, cpu_;
};

/// Returns the peak resident memory of this process so far, in bytes.
std::uint64_t peak_memory_bytes();

struct RunRecord {
    const Job* job = nullptr;
    const transport::RenderOutput* output = nullptr;
    std::vector<std::string> arguments;
    std::map<std::string, PhaseTime> phases;  ///< load, build, render, write
    std::vector<std::string> warnings;
    std::vector<display::SplitResult> splits;
    std::map<std::string, std::string> attributes;  ///< the attributes of the image header
    std::vector<display::MemoryItem> memory;        ///< of the image, by layer, as estimated before rendering
    const display::DeepBuffer* deep = nullptr;      ///< null without a deep image
    transport::EffectFindings effects{};            ///< effects that the scene needs
    Json guide_view{};                              ///< guide_view_json(), or null
};

/// Returns the statistics as JSON. experiments/docs/rendering/stats.md lists the keys.
std::string statistics_json(const RunRecord& record);

}  // namespace raylex::experiments
