#include "experiments/stability/suite/suite_runner.h"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

#include "display/output/color/color_manager.h"
#include "display/services/processor.h"
#include "display/services/thread_or_none.h"
#include "experiments/job/rendering/color_setup.h"
#include "experiments/program/interrupt.h"
#include "experiments/stability/suite/line_records.h"
#include "experiments/stability/suite/scene_measure.h"
#include "experiments/study/run/processes/child_process.h"
#include "experiments/study/run/processes/messages.h"
#include "transport/embree/embree_scene.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

/// A line that will be measured.
struct PlannedLine {
    const CaseFamily* family = nullptr;
    const StabilityCase* what = nullptr;
    Setting setting;
    std::size_t integrator = 0;  ///< index in the subject's list
    Status valid = success();    ///< error of the setting

    [[nodiscard]] LineResult unmeasured() const {
        LineResult line;
        line.family = family->name;
        line.name = what->name;
        line.setting = setting.text;
        line.rows = what->rows;
        line.tolerance = what->tolerance.text;
        if (what->scene && what->scene->integrators.size() > 1)
            line.setting += (line.setting.empty() ? "" : ", ") + what->scene->integrators[integrator];
        return line;
    }
};

std::vector<PlannedLine> planned_lines(const CaseFamily& family, const StabilityCase& what, bool only_fast) {
    auto settings = what.settings(only_fast);
    if (!settings) return {{&family, &what, {}, 0, settings.error()}};
    const std::size_t integrators = what.scene ? std::max<std::size_t>(1, what.scene->integrators.size()) : 1;
    std::vector<PlannedLine> lines;
    for (const Setting& setting : *settings)
        for (std::size_t i = 0; i < integrators; ++i) lines.push_back({&family, &what, setting, i});
    return lines;
}

/// Scales the picture so that 99 % of the values are below 1, whatever the scene's units.
void expose(std::vector<float>& rgb) {
    std::vector<float> sorted;
    std::copy_if(rgb.begin(), rgb.end(), std::back_inserter(sorted), [](float v) { return std::isfinite(v); });
    if (sorted.empty()) return;
    const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(0.99 * double(sorted.size() - 1));
    std::nth_element(sorted.begin(), bright, sorted.end());
    if (*bright > 0)
        for (float& each : rgb) each = std::isfinite(each) ? each * (0.8f / *bright) : 0;
}

/// Writes a picture. Without it its place on the page stays empty; the table does not depend on it.
void write_picture(const std::string& path, CaseImage& image) {
    auto color = display::ColorManager::open();
    if (!color || image.rgb.empty()) return;
    expose(image.rgb);
    auto bytes = color->to_display(image.rgb, chromaticities_of(transport::ColorSpace::srgb), {}, {});
    if (bytes) (void)display::write_png(path, image.width, image.height, *bytes).ok();
}

Status measure(const PlannedLine& planned, int threads, const std::string& picture, LineResult& line) {
    if (!planned.valid) return planned.valid.error();
    CaseImage image;
    Result<ProbeResult> result = ProbeResult();
    if (planned.what->scene) {
        result = measure_scene(*planned.what->scene, planned.integrator, planned.setting, threads,
                               picture.empty() ? nullptr : &image);
    } else {
        const ProbeInput input(planned.setting, planned.what->location);
        result = probe_registry().find(planned.what->probe)->factory(input);
        if (const Status complete = input.status(); !complete) return complete;
    }
    if (!result) return result.error();
    if (!picture.empty()) write_picture(picture, image);
    return run_checks(*planned.what, planned.setting, *result, line);
}

LineResult measured(const PlannedLine& planned, int threads, const std::string& picture) {
    LineResult line = planned.unmeasured();
    const transport::Stopwatch watch;
    if (const Status done = measure(planned, threads, picture, line); !done) {
        line.result = LineState::fails;
        line.measured = line.error = NAN;
        line.note = done.error().to_string();
    }
    line.seconds = watch.wall();
    return line;
}

/// Runs in the child process: answers [case] with the records of its lines, [case, line] with that of one line.
class SuiteService {
  public:
    SuiteService(const std::vector<std::vector<PlannedLine>>& cases, const SuiteOptions& options)
        : cases_(cases), options_(options) {}

    std::string answer(const std::string& request) const {
        const Message requested = unpacked(request);
        const std::vector<PlannedLine>& lines = cases_[requested.at(0).get<std::size_t>()];
        if (requested.size() > 1)
            return packed(Message::array({line_record(one(lines, requested.at(1).get<std::size_t>(), 1))}));
        Message records = Message::array();
        for (const LineResult& each : all(lines)) records.push_back(line_record(each));
        return packed(records);
    }

  private:
    LineResult one(const std::vector<PlannedLine>& lines, std::size_t index, int threads) const {
        const PlannedLine& line = lines[index];
        const bool pictured = index == 0 && !options_.pictures.empty() && line.family->picture == line.what->name;
        return measured(line, threads, pictured ? options_.pictures + "/" + line.family->name + ".png" : "");
    }
    /// Measures as many lines at once as there are threads; fewer lines get several threads each.
    std::vector<LineResult> all(const std::vector<PlannedLine>& lines) const {
        const std::size_t cores = options_.threads > 0 ? static_cast<std::size_t>(options_.threads)
                                                       : std::max(1u, std::thread::hardware_concurrency());
        const std::size_t workers = std::min(cores, lines.size());
        std::vector<LineResult> results(lines.size());
        std::atomic<std::size_t> next{0};
        std::vector<std::thread> threads;
        const auto work = [&] {
            display::flush_denormals();
            for (std::size_t line; (line = next++) < lines.size();)
                results[line] = one(lines, line, static_cast<int>(cores / workers));
        };
        for (std::size_t i = 0; i < workers; ++i) threads.push_back(display::thread_or_none(work));
        if (std::none_of(threads.begin(), threads.end(), [](const std::thread& each) { return each.joinable(); }))
            work();
        for (std::thread& thread : threads)
            if (thread.joinable()) thread.join();
        return results;
    }

    const std::vector<std::vector<PlannedLine>>& cases_;
    const SuiteOptions& options_;
};

class SuiteRun {
  public:
    SuiteRun(const SuiteOptions& options, const std::atomic<bool>* stop)
        : options_(options), stop_(stop), process_([this] {
              install_worker_interrupt_handler();
              return [service = SuiteService(cases_, options_)](const std::string& request, const Tell&) {
                  return service.answer(request);
              };
          }) {}

    void plan(const CaseFamily& family, const StabilityCase& what) {
        cases_.push_back(planned_lines(family, what, options_.fast));
    }
    [[nodiscard]] std::size_t size() const { return cases_.size(); }

    /// Returns the lines of a case. If its process crashed, measures line by line to find the one that crashes.
    Result<std::vector<LineResult>> lines_of(std::size_t index) {
        const std::vector<PlannedLine>& lines = cases_[index];
        if (!lines.front().what->not_applicable.empty()) {
            LineResult line = lines.front().unmeasured();
            line.result = LineState::not_applicable;
            line.note = lines.front().what->not_applicable;
            return std::vector{line};
        }
        std::string death;
        auto results = ask({index}, death);
        if (!results || death.empty() || stopped()) return results;
        results->clear();
        for (std::size_t i = 0; i < lines.size() && !stopped(); ++i) {
            auto one = ask({index, i}, death);
            if (!one) return one.error();
            if (death.empty()) {
                results->push_back(one->front());
                continue;
            }
            LineResult line = lines[i].unmeasured();
            line.result = LineState::died;
            line.measured = line.error = NAN;
            line.note = "the process " + death;
            results->push_back(std::move(line));
        }
        return results;
    }
    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(); }

  private:
    Result<std::vector<LineResult>> ask(const Message& request, std::string& death) {
        auto answer = process_.ask({packed(request), options_.seconds_per_case, stop_, 1, {}});
        if (!answer) return answer.error();
        death = answer->death;
        std::vector<LineResult> lines;
        if (death.empty())
            for (const Message& each : unpacked(answer->content)) lines.push_back(line_of_record(each));
        return lines;
    }

    const SuiteOptions& options_;
    const std::atomic<bool>* stop_;
    std::vector<std::vector<PlannedLine>> cases_;
    ChildProcess process_;
};

}  // namespace

std::size_t SuiteResults::count(LineState verdict) const {
    return static_cast<std::size_t>(
        std::count_if(lines.begin(), lines.end(), [&](const LineResult& line) { return line.result == verdict; }));
}

bool is_chosen(const StabilityCase& each, const SuiteOptions& options) {
    if (options.fast && each.slow) return false;
    const auto named = [&](const std::string& glob) { return fnmatch(glob.c_str(), each.name.c_str(), 0) == 0; };
    if (!options.names.empty() && std::none_of(options.names.begin(), options.names.end(), named)) return false;
    const auto has_row = [&](int row) { return std::find(each.rows.begin(), each.rows.end(), row) != each.rows.end(); };
    return options.rows.empty() || std::any_of(options.rows.begin(), options.rows.end(), has_row);
}

Result<SuiteResults> run_suite(const std::vector<CaseFamily>& families, const SuiteOptions& options,
                               const std::atomic<bool>* stop,
                               const std::function<void(const std::vector<LineResult>&)>& done) {
    const transport::Stopwatch watch;
    SuiteRun run(options, stop);
    for (const CaseFamily& family : families)
        for (const StabilityCase& each : family.cases)
            if (is_chosen(each, options)) run.plan(family, each);
    SuiteResults results;
    for (std::size_t i = 0; i < run.size() && !run.stopped(); ++i) {
        auto lines = run.lines_of(i);
        if (!lines) return lines.error();
        if (run.stopped()) break;
        done(*lines);
        results.lines.insert(results.lines.end(), lines->begin(), lines->end());
    }
    results.interrupted = run.stopped();
    results.seconds = watch.wall();
    return results;
}

}  // namespace raylex::experiments
