// What a person sees while an experiment runs: the cell at hand, its error, and the time to the end.
#pragma once

#include <cstddef>
#include <string>

#include "experiments/study/run/cells/cell_runner.h"

namespace raylex::experiments {

class RunProgress {
  public:
    /// `quiet`: says nothing.
    explicit RunProgress(bool quiet = false);
    ~RunProgress() { clear(); }
    RunProgress(const RunProgress&) = delete;
    RunProgress& operator=(const RunProgress&) = delete;

    /// `title` is what is being rendered; `seconds_left` what follows it, negative when not known; `unknown` how many
    /// cells of those cannot be told.
    void begin(std::string title, double seconds_left, std::size_t unknown);
    /// A line that redraws itself on a terminal, a plain one every few seconds elsewhere; on standard error.
    void update(const WorkProgress& now);
    /// A line that stays, on standard output.
    void line(const std::string& text);

  private:
    void clear();
    std::string title_;
    double seconds_left_ = -1;
    std::size_t unknown_ = 0, drawn_ = 0;
    double last_ = 0;
    bool quiet_, terminal_;
};

/// "3 min 20 s", "at least 3 min 20 s", "not known".
std::string time_left_text(double seconds, std::size_t unknown);

}  // namespace raylex::experiments
