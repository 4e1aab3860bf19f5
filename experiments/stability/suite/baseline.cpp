#include "experiments/stability/suite/baseline.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "display/output/comparison/comparison.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/exit_codes.h"
#include "experiments/stability/suite/line_records.h"
#include "experiments/study/run/processes/external.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

class BaselineComparison {
  public:
    BaselineComparison(const BaselineOptions& options, const std::atomic<bool>* stop)
        : options_(options), stop_(stop), place_(fs::path(options.folder) / "beside") {}

    Result<BaselineRun> run(const SuiteOptions& suite) {
        std::error_code failed;
        fs::create_directories(place_, failed);
        BaselineRun result;
        result.name = fs::path(options_.program).parent_path().filename().string();
        std::vector<std::string> words{other(), "stability", "-o", "."};
        for (const std::string& file : options_.files) words.push_back(fs::absolute(file).string());
        for (const std::string& name : suite.names) words.insert(words.end(), {"--case", name});
        for (const int row : suite.rows) words.insert(words.end(), {"--row", std::to_string(row)});
        if (suite.fast) words.emplace_back("--fast");
        auto seconds = run_command(words);
        if (!seconds) return seconds.error();
        auto results = read_results_json((place_ / "results.json").string());
        if (!results) return results.error();
        result.results = *std::move(results);
        for (const std::string& scene : options_.scenes) {
            auto difference = compare(scene);
            if (!difference) return difference.error();
            result.scenes.push_back(*difference);
        }
        return result;
    }

  private:
    [[nodiscard]] std::string other() const { return fs::absolute(options_.program).string(); }

    /// Runs a command and returns its CPU seconds.
    Result<double> run_command(const std::vector<std::string>& words) {
        ShellCommand command;
        command.text = shell_command(words);
        auto outcome = run_process(command, place_.string(), (place_ / "log.txt").string(), 0, stop_, {});
        if (!outcome) return outcome.error();
        if (outcome->exit_code != exit_holds && outcome->exit_code != exit_does_not_hold)
            return error_at({}, "'" + command.text + "' ended with " + std::to_string(outcome->exit_code) + ": " +
                                    outcome->last_words);
        return outcome->cpu_seconds;
    }

    Result<SceneDifference> compare(const std::string& scene) {
        SceneDifference difference{scene, 0, 1, 0, 0};
        std::error_code failed;
        const std::string self = fs::read_symlink("/proc/self/exe", failed).string();
        for (int run = 0; run < options_.runs; ++run)
            for (const auto& [program, image, seconds] :
                 {std::tuple(self, "this.exr", &difference.cpu_seconds),
                  std::tuple(other(), "other.exr", &difference.baseline_cpu_seconds)}) {
                auto taken = run_command({program, "render", fs::absolute(scene).string(), "-o", image, "--spp",
                                          options_.samples, "--seed", "1"});
                if (!taken) return taken.error();
                *seconds = run == 0 ? *taken : std::min(*seconds, *taken);
            }
        auto mine = display::read_exr((place_ / "this.exr").string()),
             theirs = display::read_exr((place_ / "other.exr").string());
        if (!mine) return mine.error();
        if (!theirs) return theirs.error();
        auto pair = display::LayerPair::make(*mine, *theirs, "beauty");
        if (!pair) return pair.error();
        auto error = pair->value(*display::find_metric("relmse"), 'A'),
             ratio = pair->value(*display::find_metric("mean-ratio"), 'A');
        if (!error) return error.error();
        difference.relative_mse = *error;
        if (ratio) difference.mean_ratio = *ratio;  // undefined if both images are black
        return difference;
    }

    const BaselineOptions& options_;
    const std::atomic<bool>* stop_;
    fs::path place_;
};

}  // namespace

Result<BaselineRun> run_baseline(const BaselineOptions& options, const SuiteOptions& suite,
                                 const std::atomic<bool>* stop) {
    return BaselineComparison(options, stop).run(suite);
}

}  // namespace raylex::experiments
