// How far a render is: a bar that redraws itself on a terminal, a plain line every few seconds elsewhere.
#pragma once

#include <string>

#include "experiments/cli/render/live_errors.h"
#include "transport/render/render.h"

namespace raylex::experiments {

class Progress {
  public:
    Progress();
    /// Before rendering: on a terminal, the channels whose errors are shown. Elsewhere nothing is measured.
    void begin(const transport::RenderPlan& plan);
    void update(const transport::RenderProgress& progress);
    /// Ends the line of the bar. Call once the render is over.
    void finish();

    /// The text shown, without any control character; `bar` is the width of the bar, `channels` how many errors it
    /// names at most.
    static std::string describe(const transport::RenderProgress& progress, int bar, const LiveErrors& errors = {},
                                std::size_t channels = SIZE_MAX);

  private:
    /// The longest text that fits a line of the terminal.
    [[nodiscard]] std::string line(const transport::RenderProgress& progress) const;
    LiveErrors errors_;
    bool terminal_ = false, drawn_ = false;
    double last_line_ = 0;
    std::size_t drawn_length_ = 0;
};

}  // namespace raylex::experiments
