#include "tests/stability/search/search.h"

#include <algorithm>
#include <filesystem>

#include "display/output/atomic_file.h"
#include "experiments/study/run/processes/messages.h"
#include "tests/stability/search/random_scene.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Makes the text of scene `seed`: "tame" or "wild", and the text; the text is empty where the scene is refused.
std::string answer_scene(const std::string& request, const std::string& folder) {
    limit_checking_process();
    const auto made = random_scene(unpacked(request).get<std::uint64_t>(), folder);
    std::string text = made ? transport::pbrt_text(made->scene).text : std::string();
    // Names of images hold wherever the folder goes.
    const std::string prefix = folder + "/";
    for (std::size_t at = 0; (at = text.find("\"" + prefix, at)) != std::string::npos;)
        text.erase(at + 1, prefix.size());
    return packed(Message::array({made && made->tame, text}));
}

class Search {
  public:
    Search(const SearchOptions& options, const SearchProgress& progress, const std::atomic<bool>* stop)
        : options_(options),
          progress_(progress),
          stop_(stop),
          folder_(fs::weakly_canonical(options.folder).string()),
          maker_([this] {
              return [this](const std::string& request, const Tell&) { return answer_scene(request, folder_); };
          }),
          checker_(folder_ + "/scene.pbrt", options.seconds_a_scene) {}

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
        const auto made = maker_.ask({packed(seed), options_.seconds_a_scene, stop_, 1, {}});
        if (!made) return made.error();
        if (stopped()) return success();
        ++report_.scenes;
        if (!made->death.empty()) {
            Finding finding{seed,
                            death_result,
                            {death_result, InvariantState::violated, 1, 0, "making the scene: " + made->death},
                            {},
                            {}};
            report_.findings.push_back(std::move(finding));
            return success();
        }
        const Message scene = unpacked(made->content);
        const bool tame = scene.at(0);
        const std::string text = scene.at(1);
        report_.tame += tame ? 1 : 0;
        if (text.empty()) {
            ++report_.refused;
            return success();
        }
        InvariantOptions check = options_.check;
        check.seed = seed;
        check.ordinary = tame;
        check.means = tame && options_.means_every > 0 && seed % options_.means_every == 0;
        const auto report = checker_.check(text, check, stop_);
        if (!report) return report.error();
        if (stopped()) return success();
        if (!report->refused.empty()) ++report_.refused;
        for (const InvariantResult& result : report->results) {
            ++(result.outcome == InvariantState::skipped ? report_.skipped : report_.checked)[result.invariant];
            if (result.outcome != InvariantState::violated) continue;
            if (Status status = found(seed, text, result); !status) return status;
        }
        return success();
    }

    /// Whether the scene fails by that invariant, whatever else is wrong with it.
    bool fails(const std::string& text, const InvariantResult& as, std::uint64_t seed) {
        InvariantOptions check = options_.check;
        check.seed = seed;
        if (as.invariant != death_result && as.invariant != "error") check.only = {as.invariant};
        const auto report = checker_.check(text, check, stop_);
        return report &&
               std::any_of(report->results.begin(), report->results.end(), [&](const InvariantResult& result) {
                   return result.outcome == InvariantState::violated && result.invariant == as.invariant;
               });
    }

    Status found(std::uint64_t seed, const std::string& text, const InvariantResult& result) {
        Finding finding{seed, result.invariant, result, text, {}};
        const auto lines = [](const std::string& t) { return std::size_t(std::count(t.begin(), t.end(), '\n')); };
        finding.lines_before = lines(text);
        if (fails(text, result, seed)) {
            const Shrunk shrunk = shrink_scene(
                text, [&](const std::string& t) { return fails(t, result, seed); }, options_.shrink);
            finding.text = shrunk.text;
            finding.trials = shrunk.trials;
        } else {
            finding.result.note += " (the second time it held)";
        }
        finding.lines = lines(finding.text);
        const std::string name = result.invariant + "-" + std::to_string(seed) + ".pbrt";
        finding.file = (fs::path(options_.folder) / name).string();
        const std::string content = "# " + result.invariant + ": " + one_line(finding.result.note) + "\n# " +
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
    const std::string folder_;
    transport::Stopwatch watch_;
    SearchReport report_;
    ChildProcess maker_;
    CheckingProcess checker_;
};

}  // namespace

std::string command_of(const Finding& finding) {
    std::string command = "raylex scene check --invariants --seed " + std::to_string(finding.scene);
    if (finding.invariant != death_result && finding.invariant != "error") command += " --only " + finding.invariant;
    return command + " " + fs::path(finding.file).filename().string();
}

Result<SearchReport> search_scenes(const SearchOptions& options, const SearchProgress& progress,
                                   const std::atomic<bool>* stop) {
    return Search(options, progress, stop).run();
}

}  // namespace raylex::experiments
