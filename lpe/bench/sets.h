// Sets of channels and paths that the benchmarks share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lpe/program.h"

namespace raylex::lpe::bench {

/// The first `count` expressions of data/lpe_bench_<name>.txt (osl dialect). Exits with a message when there are fewer.
[[nodiscard]] std::vector<ChannelSource> file_set(const std::string& name, std::size_t count);
/// The expressions C.*<RD'x'>.* for `count` distinct labels x.
[[nodiscard]] std::vector<ChannelSource> anywhere_labels(std::size_t count);
/// A set by name: the name of a file for file_set(), "labels" for anywhere_labels(), or "mixture" for half firsthit and
/// half labels.
[[nodiscard]] std::vector<ChannelSource> named_set(const std::string& name, std::size_t count);
/// A partition of W: 8 light groups x 16 first lobes x 4 numbers of bounces, and the light that the camera sees
/// directly.
[[nodiscard]] std::vector<ChannelSource> generated_split();

/// Compiles the channels; prints the error and exits on failure.
[[nodiscard]] Program compile_or_exit(const std::vector<ChannelSource>& channels);

struct RandomPath {
    std::vector<Event> events;  ///< camera, one to six scatterings, terminal
};
/// A fixed sequence of paths that use the labels of the sets.
[[nodiscard]] std::vector<RandomPath> random_paths(std::size_t count);

/// A linear congruential generator (Knuth, MMIX).
class Random {
  public:
    std::size_t below(std::size_t bound) {
        state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<std::size_t>(state_ >> 33) % bound;
    }

  private:
    std::uint64_t state_ = 1;
};

}  // namespace raylex::lpe::bench
