// Progress of a render: a bar that redraws itself on a terminal, a plain line every few seconds elsewhere.
#pragma once

#include <string>

#include "experiments/cli/render/live_errors.h"
#include "transport/render/render.h"

namespace raylex::experiments {

class Progress {
  public:
    Progress();
    /// Chooses the channels whose errors are shown on a terminal. Elsewhere nothing is measured. Call it before
    /// rendering.
    void begin(const transport::RenderPlan& plan);
    void update(const transport::RenderProgress& progress);
    /// Ends the line of the bar. Call it after the render.
    void finish();

    /// Returns the text of the line, without control characters. `bar` is the width of the bar in characters,
    /// `channels` the maximum number of errors.
    static std::string describe(const transport::RenderProgress& progress, int bar, const LiveErrors& errors = {},
                                std::size_t channels = SIZE_MAX);

  private:
    /// Returns the longest text that fits on a line of the terminal.
    [[nodiscard]] std::string line(const transport::RenderProgress& progress) const;
    LiveErrors errors_;
    bool terminal_ = false, drawn_ = false;
    double last_line_ = 0;
    std::size_t drawn_length_ = 0;
};

}  // namespace raylex::experiments
