#include "experiments/program/interrupt.h"
#include "display/output/atomic_file.h"
#include "experiments/program/exit_codes.h"

#include <unistd.h>
#include <csignal>
#include <cstring>

namespace raylex::experiments {
namespace {

std::atomic<bool> interrupted{false};
std::atomic<int> waiting{0};
std::atomic<const char*> words_at_once{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
                  std::atomic<const char*>::is_always_lock_free,
              "a signal handler may touch only lock-free atomics");

[[noreturn]] void end_at_once(const char* words) {
    display::remove_unfinished();
    [[maybe_unused]] const auto written = write(STDERR_FILENO, words, std::strlen(words));
    _exit(exit_interrupted);
}

extern "C" void on_interrupt(int) {
    if (interrupted.exchange(true)) end_at_once("");
    if (const char* words = words_at_once.load(); words != nullptr) end_at_once(words);
    if (waiting.load() == 0) end_at_once("raylex: interrupted\n");
}

extern "C" void on_interrupt_of_worker(int) {
    interrupted.store(true);
}

}  // namespace

void install_worker_interrupt_handler() {
    struct sigaction action = {};
    action.sa_handler = on_interrupt_of_worker;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

void install_interrupt_handler() {
    // Handles SIGINT even if the shell started this process with SIGINT ignored, as it does for background jobs,
    // because an interrupt loses nothing.
    struct sigaction action = {};
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    struct sigaction hangup = {};
    if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
}

const std::atomic<bool>& interrupt_flag() {
    return interrupted;
}

InterruptsWait::InterruptsWait() {
    waiting.fetch_add(1);
}
InterruptsWait::~InterruptsWait() {
    waiting.fetch_sub(1);
}

InterruptsAtOnce::InterruptsAtOnce(const char* last_words) {
    words_at_once.store(last_words);
    if (interrupted.load()) end_at_once(last_words);  // an interrupt may have arrived before, unnoticed
}
InterruptsAtOnce::~InterruptsAtOnce() {
    words_at_once.store(nullptr);
}

}  // namespace raylex::experiments
