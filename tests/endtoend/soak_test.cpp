// Two thousand random scenes, rendered by programs of their own: none may end one by a signal, take long, show a number
// that is none, or have layers that do not sum up to the beauty.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "random_scene.h"
#include "tests/support/folder.h"
#include "transport/import/pbrt_importer.h"

namespace {

namespace display = raylex::display;
namespace transport = raylex::transport;

constexpr std::uint64_t scenes = 2000;
constexpr unsigned seconds_for_a_scene = 10;
constexpr rlim_t memory_for_a_scene = rlim_t{1} << 30;
constexpr const char *first_variable = "RAYLEX_SOAK_FIRST", *log_variable = "RAYLEX_SOAK_LOG";

/// What is wrong with an image; empty: nothing.
std::string judge(const transport::RenderOutput& output, std::size_t partition) {
    const display::FrameBuffer& buffer = output.frame_buffer;
    std::vector<double> sum, size;
    const std::vector<double> beauty = buffer.resolve(output.beauty);
    for (std::size_t id = 0; id < buffer.channels().size(); ++id) {
        const bool light = buffer.channels()[id].style == display::ChannelStyle::expression;
        const std::vector<double> values = buffer.resolve(static_cast<display::ChannelId>(id));
        for (const double v : values)
            if (std::isnan(v) || (light && !std::isfinite(v)))
                return "channel " + buffer.channels()[id].name + " holds a number that is none";
        if (id < 1 || id > partition) continue;
        sum.resize(values.size());
        size.resize(values.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            sum[i] += values[i];
            size[i] += std::abs(values[i]);
        }
    }
    if (buffer.rejected_count() > 0) return {};  // counted: a layer may lack what another has
    for (std::size_t i = 0; i < beauty.size(); ++i) {
        // Law 1, and below it the frame buffer's quantum of 2^-80 for each of a few blocks and layers.
        const double bound = 1e-12 * (size[i] + std::abs(beauty[i])) + 0x1p-70;
        if (!(std::abs(sum[i] - beauty[i]) <= bound))
            return "the layers sum to " + std::to_string(sum[i]) + ", the beauty is " + std::to_string(beauty[i]);
    }
    return {};
}

/// "ok", "refused: ..." or "WRONG: ...".
std::string outcome_of(std::uint64_t index) {
    auto scene = transport::import_pbrt_text(soak_test::random_scene(index), "soak.pbrt");
    std::size_t partition = 0;
    const transport::RenderSettings settings = soak_test::random_settings(index, partition);
    const auto refused = [](const raylex::Error& error) {
        return (error.message.empty() ? "WRONG: refused without a word" : "refused: ") + error.to_string();
    };
    if (!scene) return refused(scene.error());
    auto output = transport::render(*scene, settings);
    if (!output) return refused(output.error());
    const std::string wrong = judge(*output, partition);
    return wrong.empty() ? "ok" : "WRONG: " + wrong;
}

struct Soak {
    std::uint64_t next = 0, ok = 0, refused = 0;
    std::vector<std::string> failures;

    void fail(std::uint64_t index, const std::string& how) {
        failures.push_back("scene " + std::to_string(index) + ": " + how + "\n" + soak_test::random_scene(index));
    }
};

/// Reads what a program that began at scene `soak.next` said before it ended.
void take_log(const std::string& log, int status, Soak& soak) {
    std::uint64_t begun = soak.next;
    bool finished = true;
    for (std::size_t at = 0, end = 0; (end = log.find('\n', at)) != std::string::npos; at = end + 1) {
        const std::string line = log.substr(at, end - at);
        const std::size_t space = line.find(' ');
        begun = std::stoull(line.substr(0, space));
        const std::string said = line.substr(space + 1);
        finished = said != "begins";
        if (said == "ok") ++soak.ok;
        else if (said.starts_with("refused")) ++soak.refused;
        else if (finished) soak.fail(begun, said);
    }
    soak.next = begun + 1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) soak.next = scenes;
    else if (WIFSIGNALED(status) && !finished) soak.fail(begun, std::string("signal ") + strsignal(WTERMSIG(status)));
    else soak.fail(begun, "the program ended with status " + std::to_string(status));
}

}  // namespace

TEST_CASE("scenes of the soak from RAYLEX_SOAK_FIRST on", "[.][soak-part]") {
    const char *first = std::getenv(first_variable), *log = std::getenv(log_variable);
    if (first == nullptr) return;
    std::FILE* file = log != nullptr ? std::fopen(log, "w") : stdout;
    REQUIRE(file != nullptr);
    for (std::uint64_t index = std::strtoull(first, nullptr, 10); index < scenes; ++index) {
        std::fprintf(file, "%llu begins\n", static_cast<unsigned long long>(index));
        std::fflush(file);
        alarm(seconds_for_a_scene);
        std::string said = outcome_of(index);
        alarm(0);
        for (char& c : said)
            if (c == '\n') c = ' ';
        std::fprintf(file, "%llu %s\n", static_cast<unsigned long long>(index), said.c_str());
        std::fflush(file);
    }
    std::fclose(file);
    std::_Exit(0);
}

TEST_CASE("random scenes end in an image whose layers sum up, or in an error", "[soak][law1][law6][law7]") {
    const raylex::test::Folder folder;
    const std::string log = folder.path("log");
    Soak soak;
    while (soak.next < scenes && soak.failures.size() < 20) {
        std::fflush(nullptr);
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            const rlimit memory{memory_for_a_scene, memory_for_a_scene}, core{0, 0};
            setrlimit(RLIMIT_AS, &memory);
            setrlimit(RLIMIT_CORE, &core);
            setenv(first_variable, std::to_string(soak.next).c_str(), 1);
            setenv(log_variable, log.c_str(), 1);
            execl("/proc/self/exe", "soak", "[soak-part]", static_cast<char*>(nullptr));
            _exit(127);
        }
        int status = 0;
        REQUIRE(waitpid(child, &status, 0) == child);
        take_log(folder.has("log") ? folder.read("log") : std::string(), status, soak);
    }
    for (const std::string& failure : soak.failures) FAIL_CHECK(failure);
    CHECK(soak.ok + soak.refused + soak.failures.size() == scenes);
    // Most scenes must be worth the trouble.
    CHECK(soak.ok > scenes / 2);
}
