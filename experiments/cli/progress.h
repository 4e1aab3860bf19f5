// How far a render is: a bar that redraws itself on a terminal, a plain line every few seconds elsewhere.
#pragma once

#include <string>

#include "transport/render/render.h"

namespace raylex::experiments {

class Progress {
  public:
    Progress();
    void update(const transport::RenderProgress& progress);
    /// Ends the line of the bar. Call once the render is over.
    void finish();

    /// The text shown, without any control character; `width` is that of the bar.
    static std::string describe(const transport::RenderProgress& progress, int width);

  private:
    bool terminal_ = false, drawn_ = false;
    double last_line_ = 0;
    std::size_t drawn_length_ = 0;
};

}  // namespace raylex::experiments
