// Progress of an experiment for people: the current cell, its error, and the remaining time.
#pragma once

#include <cstddef>
#include <string>

#include "experiments/study/run/cells/run_renderer.h"

namespace raylex::experiments {

class RunProgress {
  public:
    /// `quiet`: prints nothing.
    explicit RunProgress(bool quiet = false);
    ~RunProgress() { clear(); }
    RunProgress(const RunProgress&) = delete;
    RunProgress& operator=(const RunProgress&) = delete;

    /// Begins a cell. `title` names it; `seconds_left` is the time of the cells after it, negative if unknown;
    /// `unknown` is the number of those cells with unknown time.
    void begin(std::string title, double seconds_left, std::size_t unknown);
    /// Updates the line on standard error: it redraws itself on a terminal, or is printed every few seconds elsewhere.
    void update(const WorkProgress& now);
    /// Prints a permanent line to standard output.
    void line(const std::string& text);

  private:
    void clear();
    std::string title_;
    double seconds_left_ = -1;
    std::size_t unknown_ = 0, drawn_ = 0;
    double last_ = 0;
    bool quiet_, terminal_;
};

/// Returns a time as text: "3 min 20 s", "at least 3 min 20 s", "unknown".
std::string time_left_text(double seconds, std::size_t unknown);

}  // namespace raylex::experiments
