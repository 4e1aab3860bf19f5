#include "experiments/study/run/processes/external.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <thread>

#include "display/services/parameters.h"
#include "experiments/study/run/processes/child_process.h"

namespace raylex::experiments {
namespace {

double seconds_of(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string end_of_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    // The last non-empty lines, however much output and however many empty lines there are.
    const std::streamoff size = file.tellg(), most = 2 * static_cast<std::streamoff>(most_last_words);
    file.seekg(std::max<std::streamoff>(0, size - most));
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    return text.size() > most_last_words || size > most
               ? "..." + text.substr(text.size() - std::min(text.size(), most_last_words))
               : text;
}

std::vector<std::string> environment_of(const ShellCommand& command) {
    std::vector<std::string> list;
    for (const auto& [name, value] : command.environment) list.push_back(name + "=" + value);
    return list;
}

/// Returns the environment for exec: `added`, then this process's variables that it does not replace.
std::vector<char*> with_own_environment(const std::vector<std::string>& added) {
    std::vector<char*> list;
    for (const std::string& each : added) list.push_back(const_cast<char*>(each.c_str()));
    for (char** each = environ; *each != nullptr; ++each) {
        const std::string_view own(*each);
        const bool replaced = std::any_of(added.begin(), added.end(), [&](const std::string& other) {
            return own.starts_with(std::string_view(other).substr(0, other.find('=') + 1));
        });
        if (!replaced) list.push_back(*each);
    }
    list.push_back(nullptr);
    return list;
}

/// Runs in the child; never returns.
[[noreturn]] void become(const char* command, char* const* environment, const char* directory, const char* log) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // the parent would no longer wait for it
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGXFSZ, SIG_DFL);
    const int output = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644),
              input = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (output < 0 || input < 0 || dup2(input, 0) < 0 || dup2(output, 1) < 0 || dup2(output, 2) < 0 ||
        chdir(directory) != 0)
        _exit(126);
    execle("/bin/sh", "sh", "-c", command, static_cast<char*>(nullptr), environment);
    _exit(127);
}

}  // namespace

Result<ProcessOutcome> run_process(const ShellCommand& command, const std::string& directory, const std::string& log,
                                   double timeout_seconds, const std::atomic<bool>* stop,
                                   const std::function<void(double seconds, int group)>& progress) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
    const std::vector<std::string> added = environment_of(command);
    std::vector<char*> environment = with_own_environment(added);
    const pid_t child = fork();
    if (child < 0) return error_at({}, "cannot start a process: " + std::string(std::strerror(errno)));
    if (child == 0) become(command.text.c_str(), environment.data(), directory.c_str(), log.c_str());
    ProcessOutcome outcome;
    int status = 0;
    rusage usage{};
    // The interval costs no measurable time, and is short enough to know the wall time to a millisecond at first.
    auto pause = std::chrono::microseconds(200);
    for (bool killed = false;;) {
        const pid_t ended = wait4(child, &status, WNOHANG, &usage);
        if (ended == child) break;
        if (ended < 0 && errno != EINTR) return error_at({}, "lost a process: " + std::string(std::strerror(errno)));
        const double now = elapsed();
        outcome.timed_out = outcome.timed_out || (timeout_seconds > 0 && now > timeout_seconds);
        outcome.stopped = outcome.stopped || (stop != nullptr && stop->load());
        if ((outcome.timed_out || outcome.stopped) && !killed) {
            kill(-child, SIGKILL);
            kill(child, SIGKILL);  // the process may not have made its group yet
            killed = true;
        }
        if (progress) progress(now, child);
        std::this_thread::sleep_for(pause);
        if (pause < std::chrono::milliseconds(5)) pause *= 2;
    }
    outcome.wall_seconds = elapsed();
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
    outcome.peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // kilobytes
    outcome.last_words = end_of_file(log);
    return outcome;
}

}  // namespace raylex::experiments
