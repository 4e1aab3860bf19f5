// Files of a scene that know nothing of one another, read by several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace raylex::transport {

/// Calls `read` once with each number below `count`, from up to `threads` threads (0: all that the machine has). What
/// it throws comes out here.
void read_in_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& read);

}  // namespace raylex::transport
