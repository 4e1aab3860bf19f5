// Mutated files of every kind, each read in a process of its own: no signal, none above 10 s or 1 GiB. The process is
// forked from this one, which has everything loaded and no other thread.
#include <catch2/catch.hpp>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "tests/soak/readers.h"
#include "tests/support/folder.h"
#include "tests/support/paths.h"

using raylex::test::Folder;
using raylex::test::InputKind;

namespace {

constexpr unsigned seconds = 10;
constexpr long kilobytes = 1L << 20;  // of ru_maxrss: 1 GiB
constexpr std::size_t inputs = 2'000;

class Mutator {
  public:
    explicit Mutator(unsigned seed) : random_(seed) {}

    std::size_t below(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_); }

    std::string operator()(const InputKind& kind) {
        std::string bytes = kind.seeds[below(kind.seeds.size())];
        const std::string& other = kind.seeds[below(kind.seeds.size())];
        for (std::size_t edits = 1 + below(4); edits > 0 && !bytes.empty(); --edits) edit(bytes, other);
        return bytes;
    }

  private:
    void edit(std::string& bytes, const std::string& other) {
        const std::size_t at = below(bytes.size()), length = std::min(bytes.size() - at, 1 + below(24));
        switch (below(9)) {
            case 0:
                bytes[at] = static_cast<char>(below(256));
                break;
            case 1:
                bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ (1U << below(8)));
                break;
            case 2:
                bytes.erase(at, length);
                break;
            case 3:
                bytes.insert(at, other.substr(below(other.size()), 1 + below(40)));
                break;
            case 4:
                bytes.resize(at);
                break;
            case 5:
                replace_number(bytes, at);
                break;
            case 6:
                repeat(bytes, at, length);
                break;
            case 7:
                bytes.insert(at, 1, "\"'[]{}()<>*?.,=#\\ \n\t0-e"[below(24)]);
                break;
            default:
                overwrite(bytes, at);
                break;
        }
    }
    /// The number that begins next, in text, becomes one that readers may stumble over.
    void replace_number(std::string& bytes, std::size_t at) {
        static const std::string numbers[] = {
            "18446744073709551616", "-1",       "1e39",  "-1e309", "nan", "inf", "0", "1e-320",
            "2147483648",           "99999999", "0.1.1", "+-3"};
        at = bytes.find_first_of("0123456789", at);
        if (at == std::string::npos) return;
        const std::size_t end = bytes.find_first_not_of("0123456789.e", at);
        bytes.replace(at, (end == std::string::npos ? bytes.size() : end) - at, numbers[below(std::size(numbers))]);
    }
    /// Up to about 2 MB of the same.
    void repeat(std::string& bytes, std::size_t at, std::size_t length) {
        const std::string piece = bytes.substr(at, length);
        const std::size_t times = std::size_t{1} << below(17);
        std::string many;
        many.reserve(piece.size() * times);
        for (std::size_t i = 0; i < times; ++i) many += piece;
        bytes.insert(at, many);
    }
    /// Four bytes as sizes and offsets of binary files have them.
    void overwrite(std::string& bytes, std::size_t at) {
        static const std::uint32_t sizes[] = {0, 0xffffffff, 0x7fffffff, 0x80000000, 0x10000, 0x00ffffff, 1};
        const std::uint32_t value = sizes[below(std::size(sizes))];
        for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i) bytes[at + i] = static_cast<char>(value >> 8 * i);
    }

    std::mt19937 random_;
};

/// What the reading of a file came to; empty: it ended, in time and within memory.
std::string read_in_child(const InputKind& kind, const std::string& path) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(seconds);
        kind.read(path);
        _exit(0);
    }
    int status = 0;
    rusage usage{};
    if (child < 0 || wait4(child, &status, 0, &usage) != child) return "cannot fork";
    if (WIFSIGNALED(status)) return "ended by signal " + std::to_string(WTERMSIG(status));
    if (WEXITSTATUS(status) != 0) return "ended with status " + std::to_string(WEXITSTATUS(status));
    if (usage.ru_maxrss > kilobytes) return "took " + std::to_string(usage.ru_maxrss) + " kB";
    return {};
}

}  // namespace

TEST_CASE("2,000 mutated files of every kind end in a result or an error, none above 10 s or 1 GiB", "[law7][soak]") {
    const Folder folder;
    const std::vector<InputKind> kinds = raylex::test::input_kinds(folder.path());
    Mutator mutate(12);
    std::size_t failures = 0;
    for (std::size_t i = 0; i < inputs; ++i) {
        const InputKind& kind = kinds[i % kinds.size()];
        const std::string bytes = mutate(kind), name = "input" + kind.extension;
        const std::string path = folder.write(name, bytes);
        const std::string wrong = read_in_child(kind, path);
        if (wrong.empty()) continue;
        const std::string kept = raylex::test::binary_dir() + "/soak-" + std::to_string(i) + kind.extension;
        raylex::test::write_bytes(kept, bytes);
        FAIL_CHECK(kind.name << " " << i << " " << wrong << "; kept as " << kept);
        if (++failures == 20) break;
    }
}

TEST_CASE("mutations begin with files that are sound", "[soak]") {
    const Folder folder;
    for (const InputKind& kind : raylex::test::input_kinds(folder.path())) {
        INFO(kind.name);
        for (const std::string& seed : kind.seeds) {
            CHECK_FALSE(seed.empty());
            CHECK(kind.read(folder.write("input" + kind.extension, seed)));
        }
    }
}
