// The progress of reading and building a scene, for observers in other threads.
#pragma once

#include <atomic>
#include <cstdint>

namespace raylex::transport {

class LoadingProgress {
  public:
    /// Begins a step that counts `what`, such as "meshes"; static text.
    void begin(const char* what, std::uint64_t total = 0) {
        total_.store(total, std::memory_order_relaxed);
        done_.store(0, std::memory_order_relaxed);
        what_.store(what, std::memory_order_relaxed);
    }
    void count() { done_.fetch_add(1, std::memory_order_relaxed); }

    [[nodiscard]] const char* what() const { return what_.load(std::memory_order_relaxed); }
    [[nodiscard]] std::uint64_t done() const { return done_.load(std::memory_order_relaxed); }
    [[nodiscard]] std::uint64_t total() const { return total_.load(std::memory_order_relaxed); }  ///< 0: unknown

  private:
    std::atomic<const char*> what_{"scene file"};
    std::atomic<std::uint64_t> done_{0}, total_{0};
};

}  // namespace raylex::transport
