// Runs work that may crash in a separate process: a fork of this one that answers requests one by one. If it ends
// (signal, lack of memory, timeout), the answer describes the end, and the next request starts a new process.
#pragma once

#include <sys/types.h>
#include <atomic>
#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Number of bytes kept from the end of a process's output, to explain how it ended.
inline constexpr std::size_t most_last_words = 2000;

/// Sends a message to the parent process during a request.
using Tell = std::function<void(const std::string&)>;
/// Answers one request.
using Responder = std::function<std::string(const std::string& request, const Tell& tell)>;

class ChildProcess {
  public:
    /// `make` is called in each new process and returns its responder. The parent must be single-threaded when a
    /// process starts, at the first request and after an end.
    explicit ChildProcess(std::function<Responder()> make) : make_(std::move(make)) {}
    /// Ends the process if it runs.
    ~ChildProcess() { end(); }
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    struct Request {
        std::string content;
        double timeout_seconds = 0;               ///< 0: no timeout
        const std::atomic<bool>* stop = nullptr;  ///< forwarded as SIGTERM
        double seconds_to_stop = 1;               ///< time between SIGTERM and SIGKILL
        Tell told;
    };
    struct Answer {
        std::string content;
        std::string death;       ///< how the process ended without an answer, with its last output; empty: it answered
        bool timed_out = false;  ///< it was ended after `timeout_seconds`
    };
    /// Sends a request and waits for the answer. Errors: no process could be started.
    Result<Answer> ask(const Request& request);

    /// Ends the process. No request may be in progress.
    void end();

  private:
    Status begin();
    [[noreturn]] void serve(int requests, int answers) const;
    /// Forwards standard error of the process and keeps its end as last output.
    void pass_on_errors();
    void take_last_words(int status, bool timed_out, double timeout_seconds, Answer& answer);
    int close_and_reap();

    std::function<Responder()> make_;
    pid_t process_ = -1;
    int requests_ = -1, answers_ = -1, errors_ = -1;
    std::string last_words_;
};

}  // namespace raylex::experiments
