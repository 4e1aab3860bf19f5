// Ctrl-C as a flag: the render stops at a clean point and writes what there is. A second Ctrl-C ends at once.
#pragma once

#include <atomic>

namespace raylex::experiments {

/// From now on SIGINT and SIGTERM set the flag. Also ignores SIGXFSZ and SIGPIPE, so that a file-size limit or a closed
/// pipe becomes an error of the call that met it and never the end of the process.
void install_interrupt_handler();

/// Set once an interrupt has arrived; what transport::render watches.
const std::atomic<bool>& interrupt_flag();

}  // namespace raylex::experiments
