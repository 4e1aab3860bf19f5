// How far loading a scene is: a line that redraws itself on a terminal, a plain one every few seconds elsewhere, and
// nothing where it takes no longer than a second.
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

    /// What loading tells; it must end before this does.
    [[nodiscard]] transport::LoadingProgress* progress() { return &progress_; }
    /// Takes the line away. Call before anything else is printed.
    void finish();

    /// "loading meshes: 120 of 3000, 12.3 s".
    static std::string describe(const transport::LoadingProgress& progress, double seconds);

  private:
    void watch();

    transport::LoadingProgress progress_;
    bool terminal_ = false, over_ = false;
    std::mutex mutex_;  // of over_
    std::condition_variable ends_;
    std::thread thread_;
};

}  // namespace raylex::experiments
