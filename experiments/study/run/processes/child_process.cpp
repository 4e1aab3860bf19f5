#include "experiments/study/run/processes/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "display/services/parameters.h"
#include "experiments/program/console.h"
#include "experiments/program/interrupt.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

constexpr int poll_milliseconds = 50;

enum class Frame : char { told = 't', answer = 'a', request = 'r' };

bool write_all(int file, const char* data, std::size_t size) {
    while (size > 0) {
        const ssize_t written = write(file, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        data += written;
        size -= static_cast<std::size_t>(written);
    }
    return true;
}

bool read_all(int file, char* data, std::size_t size) {
    while (size > 0) {
        const ssize_t got = read(file, data, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        data += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

bool write_frame(int file, Frame kind, const std::string& content) {
    std::array<char, 1 + sizeof(std::uint64_t)> head{static_cast<char>(kind)};
    const std::uint64_t size = content.size();
    std::memcpy(head.data() + 1, &size, sizeof size);
    return write_all(file, head.data(), head.size()) && write_all(file, content.data(), content.size());
}

bool read_frame(int file, Frame& kind, std::string& content) {
    std::array<char, 1 + sizeof(std::uint64_t)> head{};
    if (!read_all(file, head.data(), head.size())) return false;
    kind = static_cast<Frame>(head[0]);
    std::uint64_t size = 0;
    std::memcpy(&size, head.data() + 1, sizeof size);
    content.resize(size);
    return read_all(file, content.data(), size);
}

void close_file(int& file) {
    if (file >= 0) close(file);
    file = -1;
}

std::string signal_text(int signal) {
    const char* const short_name = sigabbrev_np(signal);
    std::string text = "signal " + std::to_string(signal);
    if (short_name != nullptr) text += std::string(" (SIG") + short_name + ": " + strsignal(signal) + ")";
    return text + (signal == SIGKILL ? ", as the system does when memory runs out" : "");
}

}  // namespace

Status ChildProcess::begin() {
    std::array<int, 2> to{-1, -1}, from{-1, -1}, errors{-1, -1};
    if (pipe2(to.data(), O_CLOEXEC) != 0 || pipe2(from.data(), O_CLOEXEC) != 0 || pipe2(errors.data(), O_CLOEXEC) != 0)
        return error_at({}, "cannot make a pipe: " + std::string(std::strerror(errno)));
    std::fflush(nullptr);  // prints pending output once, before the fork
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ < 0) return error_at({}, "cannot start a process: " + std::string(std::strerror(errno)));
    if (process_ == 0) {
        // Ends the child if its parent is killed.
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (getppid() != parent) _exit(0);
        close(to[1]);
        close(from[0]);
        dup2(errors[1], STDERR_FILENO);
        serve(to[0], from[1]);
    }
    close(to[0]);
    close(from[1]);
    close(errors[1]);
    requests_ = to[1];
    answers_ = from[0];
    errors_ = errors[0];
    fcntl(errors_, F_SETFL, O_NONBLOCK);
    return success();
}

void ChildProcess::serve(int requests, int answers) const {
    install_worker_interrupt_handler();
    // If memory runs out, the system should end this process.
    std::ofstream("/proc/self/oom_score_adj") << "500";
    {
        const Responder respond = make_();
        Frame kind = Frame::request;
        for (std::string request; read_frame(requests, kind, request);) {
            const std::string answer =
                respond(request, [&](const std::string& text) { write_frame(answers, Frame::told, text); });
            if (!write_frame(answers, Frame::answer, answer)) break;
        }
    }
    // The exit handlers of the parent must not run in the child.
    _exit(0);
}

void ChildProcess::pass_on_errors() {
    std::array<char, 4096> buffer{};
    for (;;) {
        const ssize_t got = read(errors_, buffer.data(), buffer.size());
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return;
        write_all(STDERR_FILENO, buffer.data(), static_cast<std::size_t>(got));
        last_words_.append(buffer.data(), static_cast<std::size_t>(got));
        if (last_words_.size() > most_last_words) last_words_.erase(0, last_words_.size() - most_last_words);
    }
}

int ChildProcess::close_and_reap() {
    close_file(requests_);
    close_file(answers_);
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {}
    process_ = -1;
    if (errors_ >= 0) pass_on_errors();
    close_file(errors_);
    return status;
}

void ChildProcess::take_last_words(int status, bool timed_out, double timeout_seconds, Answer& answer) {
    while (!last_words_.empty() && (last_words_.back() == '\n' || last_words_.back() == ' ')) last_words_.pop_back();
    if (timed_out) answer.death = "was ended after its timeout of " + duration_text(timeout_seconds);
    else if (WIFSIGNALED(status)) answer.death = "was ended by " + signal_text(WTERMSIG(status));
    else answer.death = "ended by itself with exit code " + std::to_string(WEXITSTATUS(status));
    if (!last_words_.empty()) answer.death += "; its last output: " + last_words_;
}

Result<ChildProcess::Answer> ChildProcess::ask(const Request& request) {
    Answer answer;
    if (process_ < 0)
        if (Status s = begin(); !s) return s.error();
    last_words_.clear();
    const transport::Stopwatch watch;
    double stopped_at = -1;
    bool killed = false;
    bool alive = write_frame(requests_, Frame::request, request.content);
    while (alive) {
        std::array<pollfd, 2> files{{{answers_, POLLIN, 0}, {errors_, POLLIN, 0}}};
        const int ready = poll(files.data(), files.size(), poll_milliseconds);
        const double now = watch.wall();
        if (request.stop != nullptr && request.stop->load() && stopped_at < 0) {
            kill(process_, SIGTERM);
            stopped_at = now;
        }
        answer.timed_out = answer.timed_out || (request.timeout_seconds > 0 && now > request.timeout_seconds);
        const bool deaf = stopped_at >= 0 && now > stopped_at + request.seconds_to_stop;
        if ((answer.timed_out || deaf) && !killed) {
            kill(process_, SIGKILL);
            killed = true;
        }
        if (ready <= 0) continue;
        if (files[1].revents != 0) pass_on_errors();
        if (files[0].revents == 0) continue;
        Frame kind = Frame::answer;
        std::string content;
        alive = read_frame(answers_, kind, content);
        if (!alive) break;
        if (kind == Frame::answer) {
            pass_on_errors();
            answer.content = std::move(content);
            answer.timed_out = false;
            return answer;
        }
        if (request.told) request.told(content);
    }
    take_last_words(close_and_reap(), answer.timed_out, request.timeout_seconds, answer);
    return answer;
}

void ChildProcess::end() {
    if (process_ >= 0) close_and_reap();
}

}  // namespace raylex::experiments
