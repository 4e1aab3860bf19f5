#include "experiments/cli/interrupt.h"

#include <unistd.h>
#include <csignal>

#include "experiments/cli/command_line.h"

namespace raylex::experiments {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch only lock-free atomics");

extern "C" void on_interrupt(int) {
    if (interrupted.exchange(true)) _exit(exit_interrupted);
}

}  // namespace

void install_interrupt_handler() {
    // Even when a shell started us with SIGINT ignored, as it does for background jobs: nothing is lost by an
    // interrupt.
    struct sigaction action = {};
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
}

const std::atomic<bool>& interrupt_flag() {
    return interrupted;
}

}  // namespace raylex::experiments
