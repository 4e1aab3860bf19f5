// Progress of loading a scene: a line that redraws itself on a terminal, or a plain line every few seconds elsewhere.
// Nothing is printed in the first second.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "transport/scene/loading_progress.h"

namespace raylex::experiments {

class LoadingLine {
  public:
    LoadingLine();
    ~LoadingLine() { finish(); }
    LoadingLine(const LoadingLine&) = delete;
    LoadingLine& operator=(const LoadingLine&) = delete;

    /// The object that loading reports to. Loading must end before this object does.
    [[nodiscard]] transport::LoadingProgress* progress() { return &progress_; }
    /// Erases the line. Call it before anything else is printed.
    void finish();

    /// Returns the text of the line: "loading meshes: 120 of 3000, 12.3 s".
    static std::string describe(const transport::LoadingProgress& progress, double seconds);

  private:
    void watch();

    transport::LoadingProgress progress_;
    bool terminal_ = false, over_ = false;
    std::mutex mutex_;  // guards over_
    std::condition_variable ends_;
    std::thread thread_;
};

}  // namespace raylex::experiments
