// Work that may die, in a process of its own: a copy of this one (fork) that answers requests in turn. What ends it (a
// signal, memory that ran out, a timeout) is told as a sentence, and the next request gets a new process.
#pragma once

#include <sys/types.h>
#include <atomic>
#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Bytes kept of the end of what a process writes, to say how it ended.
inline constexpr std::size_t most_last_words = 2000;

/// Tells the asking process something while a request is being worked on.
using Tell = std::function<void(const std::string&)>;
/// Answers one request.
using Responder = std::function<std::string(const std::string& request, const Tell& tell)>;

class ChildProcess {
  public:
    /// `make` is called in each new process and makes what answers there. The asking process must have one thread when
    /// a process begins, which is at a request that finds none.
    explicit ChildProcess(std::function<Responder()> make) : make_(std::move(make)) {}
    /// Ends the process if there is one.
    ~ChildProcess() { end(); }
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    struct Request {
        std::string content;
        double timeout_seconds = 0;               ///< 0: none
        const std::atomic<bool>* stop = nullptr;  ///< passed on as SIGTERM
        double seconds_to_stop = 1;               ///< what has not answered so long after that is killed
        Tell told;
    };
    struct Answer {
        std::string content;
        std::string death;  ///< how the process ended instead of answering, with its last words; empty: it answered
        bool timed_out = false;  ///< it was ended after `timeout_seconds`
    };
    /// Errors: no process could be made.
    Result<Answer> ask(const Request& request);

    /// No request is under way: the process ends by itself, at once.
    void end();

  private:
    Status begin();
    [[noreturn]] void serve(int requests, int answers) const;
    /// Standard error of the process, passed on; its end is kept as last words.
    void pass_on_errors();
    void take_words(int status, bool timed_out, double timeout_seconds, Answer& answer);
    int close_and_reap();

    std::function<Responder()> make_;
    pid_t process_ = -1;
    int requests_ = -1, answers_ = -1, errors_ = -1;
    std::string last_words_;
};

}  // namespace raylex::experiments
