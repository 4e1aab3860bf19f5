#include "experiments/program/run_program.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "display/services/parameters.h"

namespace raylex::experiments {
namespace {

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// A file in memory. Unlike a pipe it never fills, so it can be read after the program ends. Null on failure.
File memory_file() {
    const int number = memfd_create("raylex", MFD_CLOEXEC);
    return File(number < 0 ? nullptr : fdopen(number, "w+"));
}

std::string content_of(std::FILE* file) {
    std::string text;
    std::array<char, 4096> part{};
    std::rewind(file);
    for (std::size_t size = 0; (size = std::fread(part.data(), 1, part.size(), file)) > 0;)
        text.append(part.data(), size);
    return text;
}

}  // namespace

Result<ProgramOutcome> run_program(const std::vector<std::string>& arguments, const std::string& input) {
    const auto failed = [&](int error) {
        return error_at({}, "cannot run the program '" + arguments.front() + "': " + std::strerror(error));
    };
    const std::array<File, 3> files{memory_file(), memory_file(), memory_file()};
    for (const File& file : files)
        if (!file) return failed(errno);
    if (std::fwrite(input.data(), 1, input.size(), files[0].get()) != input.size() || std::fflush(files[0].get()) != 0)
        return failed(errno);
    std::rewind(files[0].get());
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (int k = 0; k < 3; ++k)
        posix_spawn_file_actions_adddup2(&actions, fileno(files[static_cast<std::size_t>(k)].get()), k);
    std::vector<char*> texts;  // POSIX wants char*, and leaves the texts as they are
    for (const std::string& argument : arguments) texts.push_back(const_cast<char*>(argument.c_str()));
    texts.push_back(nullptr);
    pid_t process = 0;
    const int error = posix_spawnp(&process, texts.front(), &actions, nullptr, texts.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) return failed(error);
    int status = 0;
    while (waitpid(process, &status, 0) < 0)
        if (errno != EINTR) return failed(errno);
    return ProgramOutcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), content_of(files[1].get()),
                          content_of(files[2].get())};
}

}  // namespace raylex::experiments
