// Handles signals that end the program. If nothing would be lost, the program ends at once; otherwise a flag is set, so
// that the render stops at a clean point and writes its partial image. A second signal always ends the program at once.
// See experiments/docs/stopping.md.
#pragma once

#include <atomic>

namespace raylex::experiments {

/// Makes SIGINT, SIGTERM and SIGHUP end the program with exit code 130, or set the flag while an InterruptsWait exists.
/// A SIGHUP that was ignored (nohup) stays ignored. Also ignores SIGXFSZ and SIGPIPE, so that a file-size limit or a
/// closed pipe is an error of the system call instead of the end of the process.
void install_interrupt_handler();

/// Makes these signals only set the flag, any number of times. For a process that works for another one, which ends it
/// if necessary.
void install_worker_interrupt_handler();

/// The flag that an interrupt sets. transport::render checks it.
const std::atomic<bool>& interrupt_flag();

/// While one exists, an interrupt only sets the flag, so that work in progress can be saved.
class InterruptsWait {
  public:
    InterruptsWait();
    ~InterruptsWait();
    InterruptsWait(const InterruptsWait&) = delete;
    InterruptsWait& operator=(const InterruptsWait&) = delete;
};

/// While one exists, an interrupt ends the program at once, whatever InterruptsWait objects exist. For long work that
/// does not check the flag and is lost without harm. Only one may exist at a time.
class InterruptsAtOnce {
  public:
    /// `last_words` is printed on an interrupt. The string must outlive this object.
    explicit InterruptsAtOnce(const char* last_words);
    ~InterruptsAtOnce();
    InterruptsAtOnce(const InterruptsAtOnce&) = delete;
    InterruptsAtOnce& operator=(const InterruptsAtOnce&) = delete;
};

}  // namespace raylex::experiments
