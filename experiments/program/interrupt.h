// Signals that end the program: at once where nothing would be lost, else as a flag, so that the render stops at a
// clean point and writes what there is. A second signal ends the program at once in any case. See
// experiments/docs/stopping.md.
#pragma once

#include <atomic>

namespace raylex::experiments {

/// From now on SIGINT, SIGTERM and SIGHUP end the program with exit code 130, or set the flag while an InterruptsWait
/// lives. A SIGHUP that was ignored (nohup) stays ignored. Also ignores SIGXFSZ and SIGPIPE, so that a file-size limit
/// or a closed pipe becomes an error of the call that met it and never the end of the process.
void install_interrupt_handler();

/// In a process that works for another one: these signals set the flag, however often they come. The one that asks for
/// the work ends it when it must.
void install_worker_interrupt_handler();

/// Set once an interrupt has arrived; what transport::render watches.
const std::atomic<bool>& interrupt_flag();

/// While one lives there is something to lose: an interrupt waits for whoever watches the flag.
class InterruptsWait {
  public:
    InterruptsWait();
    ~InterruptsWait();
    InterruptsWait(const InterruptsWait&) = delete;
    InterruptsWait& operator=(const InterruptsWait&) = delete;
};

/// While one lives, however many InterruptsWait there are, an interrupt ends the program at once: for work that may
/// take long, watches nothing, and that somebody who starts again loses nothing by. One at a time.
class InterruptsAtOnce {
  public:
    /// What is printed then; a string that stays.
    explicit InterruptsAtOnce(const char* last_words);
    ~InterruptsAtOnce();
    InterruptsAtOnce(const InterruptsAtOnce&) = delete;
    InterruptsAtOnce& operator=(const InterruptsAtOnce&) = delete;
};

}  // namespace raylex::experiments
