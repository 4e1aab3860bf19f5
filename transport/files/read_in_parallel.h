// Reads independent files of a scene with several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace raylex::transport {

/// Calls `read` once with each number below `count`, from up to `threads` threads (0: all of the machine). Exceptions
/// of `read` are rethrown.
void read_in_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& read);

}  // namespace raylex::transport
