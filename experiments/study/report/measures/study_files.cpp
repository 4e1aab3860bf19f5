#include "experiments/study/report/measures/study_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "experiments/job/text/json.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"') result += '"';
        result += c;
    }
    return result + "\"";
}

std::string csv_number(double value) {
    return std::isfinite(value) ? number_text(value, 9) : std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json json_of(const Interval& interval) {
    Json json{{"value", number(interval.value)}, {"low", number(interval.low)}, {"high", number(interval.high)}};
    if (!interval.note.empty()) json["note"] = interval.note;
    if (!interval.how.empty()) json["how"] = interval.how;
    return json;
}

Json curve_key(const char* kind, const Curve& curve) {
    return Json{{"kind", kind},
                {"scene", curve.scene},
                {"variant", curve.variant},
                {"channel", curve.channel},
                {"region", curve.region}};
}

Json json_of(const Line& line) {
    return Json{{"slope", number(line.slope)}, {"low", number(line.slope_low)}, {"high", number(line.slope_high)}};
}

class Lines {
  public:
    void add(const Json& json) {
        // Names come from users; bytes that are not UTF-8 are replaced.
        text_ += json_text(json) + "\n";
    }
    [[nodiscard]] std::string take() { return std::move(text_); }

  private:
    std::string text_;
};

void add_curve(Lines& lines, const Curve& curve) {
    for (const BudgetPoint& point : curve.points) {
        Json json = curve_key("budget", curve);
        json["budget_kind"] = budget_kind_name(curve.budget_kind);
        json["budget"] = point.budget;
        json["replicates"] = point.group.errors.size();
        json["relmse_mean"] = json_of(point.squared);
        json["relative_error"] = json_of(point.relative);
        json["reference_excess"] = number(point.excess);
        json["efficiency"] = json_of(point.efficiency);
        json["wall_seconds"] = number(point.wall_seconds);
        json["cpu_seconds"] = number(point.cpu_seconds);
        json["samples_per_pixel"] = number(point.samples);
        json["tail_index"] = number(point.tail_index);
        lines.add(json);
    }
    Json slope = curve_key("slope", curve);
    if (curve.slope.samples) slope["against_samples"] = json_of(*curve.slope.samples);
    if (curve.slope.seconds) slope["against_seconds"] = json_of(*curve.slope.seconds);
    slope["too_shallow"] = curve.slope.too_shallow;
    slope["nears"] = curve.slope.nears;
    slope["verdict"] = curve.slope.text;
    slope["speed_up"] = json_of(curve.speed_up);
    lines.add(slope);
    for (const TimeToError& time : curve.times) {
        Json json = curve_key("time_to_error", curve);
        json["relative_error"] = time.relative_error;
        json["seconds"] = json_of(time.seconds);
        json["extrapolated"] = time.extrapolated;
        lines.add(json);
    }
    if (curve.prediction) {
        Json json = curve_key("prediction", curve);
        json["predicted_seconds"] = number(curve.prediction->predicted_seconds);
        json["actual_seconds"] = number(curve.prediction->actual_seconds);
        json["octaves_ahead"] = number(curve.prediction->octaves_ahead);
        lines.add(json);
    }
}

}  // namespace

std::string plain_number(double value, int digits) {
    const double size = std::abs(value);
    if (size == 0 || size < 1e-6 || !(size < 1e9)) return number_text(value, digits);
    // Rounds first, because 999.6 to three digits has four digits before the point.
    const double rounded = std::strtod(number_text(value, digits).c_str(), nullptr);
    const int decimals = std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(rounded)))));
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, rounded);
    std::string result = text.data();
    if (result.find('.') != std::string::npos) {
        result.erase(result.find_last_not_of('0') + 1);
        if (result.back() == '.') result.pop_back();
    }
    return result;
}

std::string percent_text(double share, int digits) {
    return plain_number(share * 100, digits) + " %";
}

std::string spoken_budget(BudgetKind kind, double budget) {
    switch (kind) {
        case BudgetKind::samples:
            return number_text(budget, 9) + (budget == 1 ? " sample" : " samples");
        case BudgetKind::seconds:
            return number_text(budget, 6) + " s";
        case BudgetKind::error:
            break;
    }
    return "to " + percent_text(budget, 4);
}

namespace {

struct Column {
    const char *name, *unit, *meaning;
};

constexpr std::array<Column, 15> run_columns{{
    {"cell", "", "name of the cell in cells/"},
    {"scene", "", "the scene's name"},
    {"variant", "", "method and swept settings"},
    {"budget_kind", "", "samples, seconds or error"},
    {"budget", "samples per pixel, s, or share", "requested budget; a share of 0.01 is 1 %"},
    {"replicate", "", "from 0"},
    {"seed", "", "seed of the render"},
    {"samples_per_pixel", "", "samples reached; for adaptive sampling the rounded mean"},
    {"wall_seconds", "s", "preparation and rendering, or the external process"},
    {"cpu_seconds", "s", "CPU time of all threads, for the same work"},
    {"rays", "", "rays traced; 0 if unknown"},
    {"invalid_samples", "", "number of contributions that were not finite"},
    {"peak_memory_bytes", "B", "peak memory of the process; 0 if unknown"},
    {"channel", "", "channel of light, or the beauty"},
    {"region", "", "empty: the whole image"},
}};

constexpr std::array<Column, 3> closing_columns{{
    {"trimmed_share", "share", "share of relmse_mean's sum that relmse-trimmed omits"},
    {"reference_mse", "", "expected contribution of the reference's noise to mse: mean(Var(b))"},
    {"reference_relmse_mean", "",
     "expected contribution of the reference's noise to relmse_mean: mean(Var(b) / (b^2 + (0.1 m)^2))"},
}};

/// Returns a name as a column name for other programs: "relmse-mean" becomes relmse_mean.
std::string column_name(std::string name) {
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

void add_formulas(Lines& lines) {
    Json formulas{{"kind", "formulas"}};
    for (const display::ErrorMetricInfo& each : display::error_metrics()) formulas[each.name] = each.formula;
    for (const display::ImageMetric each : seen_metrics)
        formulas[display::info_of(each).name] = display::info_of(each).formula;
    lines.add(formulas);
}

void add_run(Lines& lines, const StudyRun& run) {
    Json json{{"kind", "run"},
              {"cell", run.id},
              {"scene", run.scene},
              {"variant", variant_name(run)},
              {"budget_kind", budget_kind_name(run.budget_kind)},
              {"budget", number(run.budget)},
              {"replicate", run.replicate},
              {"seed", run.seed},
              {"samples_per_pixel", run.samples_per_pixel},
              {"wall_seconds", number(run.wall_seconds)},
              {"cpu_seconds", number(run.cpu_seconds)},
              {"rays", run.rays},
              {"other_load", number(run.other_load < 0 ? NAN : run.other_load)},
              {"invalid_samples", run.invalid_samples},
              {"peak_memory_bytes", run.peak_memory_bytes}};
    if (run.failed) json["failure"] = run.failure;
    lines.add(json);
}

void add_spectrum(Lines& lines, const ErrorSpectrum& spectrum) {
    const Curve& curve = *spectrum.curve;
    Json json = curve_key("spectrum", curve);
    json["budget"] = curve.points.back().budget;
    json["replicates"] = spectrum.replicates;
    json["reference_error"] = number(spectrum.reference_error);
    for (const ErrorSpectrum::Point& each : spectrum.points) {
        json["cycles_per_pixel"].push_back(number(each.frequency));
        json["power"].push_back(number(each.mean));
        json["least"].push_back(number(each.least));
        json["most"].push_back(number(each.most));
    }
    lines.add(json);
}

void add_errors(Lines& lines, const RunErrors& row) {
    Json json{{"kind", "cell"},         {"cell", row.run->id},    {"scene", row.run->scene},
              {"variant", row.variant}, {"channel", row.channel}, {"region", row.region}};
    for (const display::ErrorMetricInfo& each : display::error_metrics())
        json[each.name] = number(row.measures[each.metric]);
    for (std::size_t i = 0; i < seen_metrics.size(); ++i)
        if (!std::isnan(row.seen[i])) json[display::info_of(seen_metrics[i]).name] = number(row.seen[i]);
    json["trimmed_share"] = number(row.measures.trimmed_share);
    lines.add(json);
}

void add_bias(Lines& lines, const Study& study, const BiasEntry& entry) {
    const BiasTest& v = entry.result;
    lines.add(Json{{"kind", "bias"},
                   {"scene", entry.scene},
                   {"variant", entry.variant},
                   {"channel", entry.channel},
                   {"budget", entry.budget},
                   {"replicates", entry.replicates},
                   {"tested", v.tested},
                   {"differs", v.differs},
                   {"heavy_tail", entry.heavy_tail},
                   {"omitted", entry.omitted},
                   {"convicts", entry.convicts()},
                   {"verdict", result_of(study, entry)},
                   {"against", entry.against},
                   {"adjusted_p", number(v.adjusted_p)},
                   {"tests", v.tests},
                   {"mean_difference", number(v.mean_difference.value)},
                   {"mean_low", number(v.mean_difference.low)},
                   {"mean_high", number(v.mean_difference.high)},
                   {"worst_block", v.worst},
                   {"worst_is_whole_image", v.worst_is_whole},
                   {"worst_difference", number(v.worst_difference.value)},
                   {"worst_low", number(v.worst_difference.low)},
                   {"worst_high", number(v.worst_difference.high)},
                   {"detectable_whole", number(v.detectable_whole)},
                   {"detectable_block", number(v.detectable_block)},
                   {"note", v.note}});
}

}  // namespace

std::string columns_csv() {
    std::string text = "column,unit,meaning\r\n";
    const auto add = [&](const std::string& name, const std::string& unit, const std::string& meaning) {
        text += quoted(name) + "," + quoted(unit) + "," + quoted(meaning) + "\r\n";
    };
    for (const Column& each : run_columns) add(each.name, each.unit, each.meaning);
    for (const display::ErrorMetricInfo& each : display::error_metrics()) add(column_name(each.name), "", each.formula);
    for (const display::ImageMetric each : seen_metrics) {
        std::string meaning = std::string("of the beauty: ") + display::info_of(each).formula;
        std::replace(meaning.begin(), meaning.end(), '\n', ' ');  // one line per column
        add(column_name(display::info_of(each).name), "", meaning);
    }
    for (const Column& each : closing_columns) add(each.name, each.unit, each.meaning);
    return text;
}

std::string results_csv(const Study& study) {
    std::string text;
    for (const Column& each : run_columns) text += (text.empty() ? "" : ",") + std::string(each.name);
    for (const display::ErrorMetricInfo& each : display::error_metrics()) text += "," + column_name(each.name);
    for (const display::ImageMetric each : seen_metrics) text += "," + column_name(display::info_of(each).name);
    for (const Column& each : closing_columns) text += "," + std::string(each.name);
    text += "\r\n";
    for (const RunErrors& row : study.runs) {
        const StudyRun& run = *row.run;
        text += quoted(run.id) + "," + quoted(run.scene) + "," + quoted(row.variant) + "," +
                budget_kind_name(run.budget_kind) + "," + csv_number(run.budget) + "," + std::to_string(run.replicate) +
                "," + std::to_string(run.seed) + "," + std::to_string(run.samples_per_pixel) + "," +
                csv_number(run.wall_seconds) + "," + csv_number(run.cpu_seconds) + "," + std::to_string(run.rays) +
                "," + std::to_string(run.invalid_samples) + "," + std::to_string(run.peak_memory_bytes) + "," +
                quoted(row.channel) + "," + quoted(row.region);
        for (const double value : row.measures.values) text += "," + csv_number(value);
        for (const double value : row.seen) text += "," + csv_number(value);
        text += "," + csv_number(row.measures.trimmed_share) + "," + csv_number(row.mse_excess) + "," +
                csv_number(row.relmse_excess) + "\r\n";
    }
    return text;
}

std::string results_jsonl(const Study& study) {
    Lines lines;
    add_formulas(lines);
    for (const StudyRun& run : study.experiment->runs) add_run(lines, run);
    for (const RunErrors& row : study.runs) add_errors(lines, row);
    for (const Curve& curve : study.curves) add_curve(lines, curve);
    for (const BiasEntry& entry : study.bias) add_bias(lines, study, entry);
    for (const MethodComparison& each : study.comparisons)
        lines.add(Json{{"kind", "best"},
                       {"scene", each.scene},
                       {"channel", each.channel},
                       {"seconds", number(each.seconds)},
                       {"variant", study.variants[each.best].name},
                       {"ratio", json_of(each.ratio)},
                       {"sentence", best_sentence(study, each)}});
    for (const CounterexampleEntry& entry : study.words)
        for (const Counterexamples::Counterexample& word : entry.first.words)
            lines.add(Json{{"kind", "first_words"},
                           {"scene", entry.scene},
                           {"variant", entry.variant},
                           {"channel", word.channel},
                           {"path", word.text},
                           {"sentence", word.sentence},
                           {"adjusted_p", number(word.adjusted_p)}});
    for (const SettingEffect& effect : study.effects)
        lines.add(Json{{"kind", "setting"},
                       {"scene", effect.scene},
                       {"channel", effect.channel},
                       {"setting", effect.key},
                       {"from", effect.from},
                       {"to", effect.to},
                       {"others", effect.others},
                       {"speed_up", json_of(effect.speed_up)},
                       {"speed_up_by_medians", number(effect.by_medians)}});
    for (const ErrorSpectrum& spectrum : study.spectra) add_spectrum(lines, spectrum);
    for (const StudyRun& run : study.experiment->runs)
        for (const PartitionResult& split : run.splits)
            lines.add(Json{{"kind", "split"},
                           {"cell", run.id},
                           {"partition", split.partition},
                           {"holds", split.holds},
                           {"worst_relative_error", number(split.worst_relative_error)}});
    for (const Omission& omission : study.omissions)
        lines.add(Json{{"kind", "omission"}, {"what", omission.what}, {"reason", omission.reason}});
    return lines.take();
}

}  // namespace raylex::experiments
