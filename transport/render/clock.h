// Wall and CPU time, separately: with more threads than processors, or on a busy machine, only CPU time measures the
// work.
#pragma once

#include <chrono>
#include <ctime>

namespace raylex::transport {

inline double cpu_seconds(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
/// CPU time of the calling thread.
inline double thread_cpu_seconds() {
    return cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
}

/// Measures time since its construction.
class Stopwatch {
  public:
    [[nodiscard]] double wall() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
    }
    [[nodiscard]] double process_cpu() const { return cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_; }

  private:
    std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
    double cpu_ = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
};

}  // namespace raylex::transport
