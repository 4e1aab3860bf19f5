#include "experiments/invariants/search.h"

#include <sys/resource.h>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <sstream>

#include "display/output/atomic_file.h"
#include "experiments/invariants/random_scene.h"
#include "experiments/study/run/processes/child_process.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
constexpr const char* death = "death";
constexpr rlim_t memory_of_a_process = rlim_t{3} << 30;  ///< a scene that needs more is rejected for lack of memory

// --- what goes between the processes: fields, each with its length in front ---

void put(std::string& bytes, const std::string& field) {
    bytes += std::to_string(field.size()) + " " + field;
}
void put(std::string& bytes, double number) {
    std::array<char, 40> text{};
    put(bytes, std::string(text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr));
}
class Fields {
  public:
    explicit Fields(const std::string& bytes) : bytes_(bytes) {}
    [[nodiscard]] bool more() const { return at_ < bytes_.size(); }
    std::string text() {
        const std::size_t blank = bytes_.find(' ', at_);
        const std::size_t size = std::stoull(bytes_.substr(at_, blank - at_));
        at_ = blank + 1 + size;
        return bytes_.substr(blank + 1, size);
    }
    double number() { return std::strtod(text().c_str(), nullptr); }

  private:
    const std::string& bytes_;
    std::size_t at_ = 0;
};

std::string bytes_of(const SceneReport& report) {
    std::string bytes;
    put(bytes, report.refused);
    for (const Verdict& verdict : report.verdicts) {
        put(bytes, verdict.invariant);
        put(bytes, static_cast<double>(verdict.outcome));
        put(bytes, verdict.measured);
        put(bytes, verdict.bound);
        put(bytes, verdict.note);
    }
    return bytes;
}
SceneReport report_of(Fields fields) {
    SceneReport report;
    report.refused = fields.text();
    while (fields.more()) {
        Verdict& verdict = report.verdicts.emplace_back();
        verdict.invariant = fields.text();
        verdict.outcome = static_cast<InvariantState>(fields.number());
        verdict.measured = fields.number();
        verdict.bound = fields.number();
        verdict.note = fields.text();
    }
    return report;
}

/// The worker process. It makes the text of a scene ("scene N"), or checks a scene.
class Worker {
  public:
    Worker(const SearchOptions& options, const std::string& path)
        : options_(options),
          path_(path),
          process_([this] { return [this](const std::string& request, const Tell&) { return answer(request); }; }) {}

    /// Returns "tame" or "wild" and the scene's text; empty if the scene is rejected.
    Result<ChildProcess::Answer> make_scene(std::uint64_t seed, const std::atomic<bool>* stop) {
        std::string request;
        put(request, "scene");
        put(request, std::to_string(seed));
        return process_.ask({request, options_.seconds_a_scene, stop, 1, {}});
    }
    Result<SceneReport> check(const std::string& text, const InvariantOptions& check, const std::atomic<bool>* stop) {
        std::string request;
        put(request, "check");
        put(request, text);
        put(request, std::to_string(check.seed));
        put(request, check.means ? "means" : "");
        put(request, check.ordinary ? "ordinary" : "");
        for (const std::string& name : check.only) put(request, name);
        const auto answer = process_.ask({request, options_.seconds_a_scene, stop, 1, {}});
        if (!answer) return answer.error();
        if (!answer->death.empty()) {
            SceneReport report;
            report.verdicts.push_back({death, InvariantState::violated, 1, 0, answer->death});
            return report;
        }
        Fields fields(answer->content);
        const std::string error = fields.text();
        if (!error.empty()) return error_at({}, error);
        return report_of(fields);
    }

  private:
    /// Replaces image paths by relative names, so that the scene can move with its folder.
    [[nodiscard]] std::string with_relative_files(std::string text) const {
        const std::string folder = fs::weakly_canonical(fs::path(path_).parent_path()).string() + "/";
        for (std::size_t at = 0; (at = text.find("\"" + folder, at)) != std::string::npos;)
            text.erase(at + 1, folder.size());
        return text;
    }
    std::string answer(const std::string& request) {
        const rlimit core{0, 0};
        setrlimit(RLIMIT_CORE, &core);
#ifndef __SANITIZE_ADDRESS__  // the address sanitizer reserves terabytes of address space
        const rlimit memory{memory_of_a_process, memory_of_a_process};
        setrlimit(RLIMIT_AS, &memory);
#endif
        Fields fields(request);
        std::string bytes;
        if (fields.text() == "scene") {
            const auto made = random_scene(std::stoull(fields.text()), fs::path(path_).parent_path().string());
            put(bytes, made && made->tame ? "tame" : "wild");
            put(bytes, made ? with_relative_files(transport::pbrt_text(made->scene).text) : std::string());
            return bytes;
        }
        const std::string text = fields.text();
        InvariantOptions check = options_.check;
        check.seed = std::stoull(fields.text());
        check.means = !fields.text().empty();
        check.ordinary = !fields.text().empty();
        check.only.clear();
        while (fields.more()) check.only.push_back(fields.text());
        const auto report = check_invariants(text, path_, check);
        put(bytes, report ? std::string() : report.error().to_string());
        return report ? bytes + bytes_of(*report) : bytes;
    }

    const SearchOptions& options_;
    std::string path_;
    ChildProcess process_;
};

class Search {
  public:
    Search(const SearchOptions& options, const SearchProgress& progress, const std::atomic<bool>* stop)
        : options_(options),
          progress_(progress),
          stop_(stop),
          path_((fs::weakly_canonical(options.folder) / "scene.pbrt").string()),
          worker_(options_, path_) {}

    Result<SearchReport> run() {
        if (Status status = write_scene_files(options_.folder); !status) return status.error();
        for (std::uint64_t seed = options_.seed; !finished(); ++seed) {
            if (Status status = take(seed); !status) return status.error();
            report_.seconds = watch_.wall();
            if (progress_) progress_(report_, nullptr);
        }
        return std::move(report_);
    }

  private:
    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(); }
    [[nodiscard]] bool finished() const {
        return stopped() || (options_.scenes > 0 && report_.scenes >= options_.scenes) ||
               (options_.seconds > 0 && watch_.wall() >= options_.seconds) ||
               report_.findings.size() >= options_.most_findings;
    }

    Status take(std::uint64_t seed) {
        const auto made = worker_.make_scene(seed, stop_);
        if (!made) return made.error();
        if (stopped()) return success();
        ++report_.scenes;
        if (!made->death.empty()) {
            Finding finding{
                seed, death, {death, InvariantState::violated, 1, 0, "making the scene: " + made->death}, {}, {}};
            report_.findings.push_back(std::move(finding));
            return success();
        }
        Fields fields(made->content);
        const bool tame = fields.text() == "tame";
        const std::string text = fields.text();
        report_.tame += tame ? 1 : 0;
        if (text.empty()) {
            ++report_.refused;
            return success();
        }
        InvariantOptions check = options_.check;
        check.seed = seed;
        check.ordinary = tame;
        check.means = tame && options_.means_every > 0 && seed % options_.means_every == 0;
        const auto report = worker_.check(text, check, stop_);
        if (!report) return report.error();
        if (stopped()) return success();
        if (!report->refused.empty()) ++report_.refused;
        for (const Verdict& verdict : report->verdicts) {
            ++(verdict.outcome == InvariantState::skipped ? report_.skipped : report_.checked)[verdict.invariant];
            if (verdict.outcome != InvariantState::violated) continue;
            if (Status status = found(seed, text, verdict); !status) return status;
        }
        return success();
    }

    /// Returns whether the scene violates the same invariant, whatever else fails.
    bool fails(const std::string& text, const Verdict& as, std::uint64_t seed) {
        InvariantOptions check = options_.check;
        check.seed = seed;
        if (as.invariant != death && as.invariant != "error") check.only = {as.invariant};
        const auto report = worker_.check(text, check, stop_);
        return report && std::any_of(report->verdicts.begin(), report->verdicts.end(), [&](const Verdict& verdict) {
                   return verdict.outcome == InvariantState::violated && verdict.invariant == as.invariant;
               });
    }

    Status found(std::uint64_t seed, const std::string& text, const Verdict& verdict) {
        Finding finding{seed, verdict.invariant, verdict, text, {}};
        const auto lines = [](const std::string& t) { return std::size_t(std::count(t.begin(), t.end(), '\n')); };
        finding.lines_before = lines(text);
        if (fails(text, verdict, seed)) {
            const Shrunk shrunk = shrink_scene(
                text, [&](const std::string& t) { return fails(t, verdict, seed); }, options_.shrink);
            finding.text = shrunk.text;
            finding.trials = shrunk.trials;
        } else {
            finding.verdict.note += " (it held the second time)";
        }
        finding.lines = lines(finding.text);
        const std::string name = verdict.invariant + "-" + std::to_string(seed) + ".pbrt";
        finding.file = (fs::path(options_.folder) / name).string();
        const std::string content = "# " + verdict.invariant + ": " + one_line(finding.verdict.note) + "\n# " +
                                    command_of(finding) + "\n" + finding.text;
        auto file = display::AtomicFile::create(finding.file);
        if (!file) return file.error();
        if (!file->write(content.data(), content.size())) return file->failure();
        if (Status status = file->commit(); !status) return status;
        report_.findings.push_back(std::move(finding));
        report_.seconds = watch_.wall();
        if (progress_) progress_(report_, &report_.findings.back());
        return success();
    }
    static std::string one_line(std::string text) {
        std::replace(text.begin(), text.end(), '\n', ' ');
        return text;
    }

    SearchOptions options_;
    const SearchProgress& progress_;
    const std::atomic<bool>* stop_;
    std::string path_;
    transport::Stopwatch watch_;
    SearchReport report_;
    Worker worker_;
};

}  // namespace

std::string command_of(const Finding& finding) {
    std::string command = "raylex scene check --invariants --seed " + std::to_string(finding.scene);
    if (finding.invariant != death && finding.invariant != "error") command += " --only " + finding.invariant;
    return command + " " + fs::path(finding.file).filename().string();
}

Result<SearchReport> search_scenes(const SearchOptions& options, const SearchProgress& progress,
                                   const std::atomic<bool>* stop) {
    return Search(options, progress, stop).run();
}

Result<SceneReport> check_in_process(const std::string& text, const std::string& path, const InvariantOptions& options,
                                     double timeout_seconds, const std::atomic<bool>* stop) {
    SearchOptions search;
    search.check = options;
    search.seconds_a_scene = timeout_seconds;
    return Worker(search, path).check(text, options, stop);
}

}  // namespace raylex::experiments
