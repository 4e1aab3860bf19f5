// What a render cost and what it met, as JSON.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "display/output/splits/split_check.h"
#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Wall and CPU seconds (all threads) of one phase.
struct PhaseTime {
    double wall_seconds = 0, cpu_seconds = 0;
};

/// Both clocks since construction.
class PhaseClock {
  public:
    PhaseClock();
    [[nodiscard]] PhaseTime elapsed() const;

  private:
    double wall_, cpu_;
};

/// Largest resident set of this process so far, bytes.
std::uint64_t peak_memory_bytes();

struct RunRecord {
    const Job* job = nullptr;
    const transport::RenderOutput* output = nullptr;
    std::vector<std::string> arguments;
    std::map<std::string, PhaseTime> phases;  ///< load, build, render, write
    std::vector<std::string> warnings;
    std::vector<display::SplitVerdict> splits;
    std::map<std::string, std::string> attributes;  ///< as in the image header
    std::vector<display::MemoryItem> memory;        ///< of the image, layer by layer, as estimated before rendering
    const display::DeepBuffer* deep = nullptr;      ///< null when there is none
    transport::EffectFindings effects{};            ///< what the scene calls for
};

/// experiments/docs/rendering/stats.md lists the keys.
std::string statistics_json(const RunRecord& record);

}  // namespace raylex::experiments
