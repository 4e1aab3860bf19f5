#include "experiments/study/report/page/study_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {
std::string text_cell(const std::string& text) {
    return "<td>" + escape_html(text) + "</td>";
}

std::string table(const std::string& head, const std::string& rows) {
    return "<div class=\"wide\"><table>\n<thead><tr>" + head + "</tr></thead>\n<tbody>\n" + rows +
           "</tbody></table></div>\n";
}

namespace {

std::string cell(const std::string& html, const char* type = "number") {
    return "<td class=\"" + std::string(type) + "\">" + html + "</td>";
}

std::string formula_header(const std::string& name, const std::string& formula) {
    return "<th class=\"formula\">" + escape_html(name) + "<code>" + escape_html(formula) + "</code></th>";
}

std::string row(const std::string& cells) {
    return "<tr>" + cells + "</tr>\n";
}

/// Returns a number for people: without an exponent, or with a superscript.
std::string figure(double value, int digits = 3) {
    if (std::isnan(value)) return "&ndash;";
    if (!std::isfinite(value)) return value > 0 ? "&infin;" : "&minus;&infin;";
    if (value == 0 || (std::abs(value) >= 1e-4 && std::abs(value) < 1e6)) return plain_number(value, digits);
    const auto power = static_cast<int>(std::floor(std::log10(std::abs(value))));
    return plain_number(value / std::pow(10.0, power), digits) + " &times; 10<sup>" + std::to_string(power) + "</sup>";
}

/// Collects the reasons in a table's cells. Each appears once below the table, with a letter.
class Footnotes {
  public:
    std::string sign(const std::string& note) {
        if (note.empty()) return {};
        const auto known = std::find(notes_.begin(), notes_.end(), note);
        const auto place = static_cast<std::size_t>(known - notes_.begin());
        if (known == notes_.end()) notes_.push_back(note);
        return "<sup class=\"sign\" title=\"" + escape_html(note) + "\">" + letter(place) + "</sup>";
    }
    [[nodiscard]] std::string legend(const std::string& first = {}) const {
        std::string text = first;
        for (std::size_t i = 0; i < notes_.size(); ++i)
            text += (text.empty() ? "" : " &nbsp; ") + ("<sup>" + letter(i) + "</sup> " + escape_html(notes_[i])) + ".";
        return text.empty() ? text : "<p class=\"note\">" + text + "</p>\n";
    }

  private:
    static std::string letter(std::size_t place) {
        const std::string last(1, static_cast<char>('a' + place % 26));
        return place < 26 ? last : letter(place / 26 - 1) + last;
    }
    std::vector<std::string> notes_;
};

/// Returns the cell "12.3 s <range>[11.9, 12.7]</range>", or a dash without a value. Notes become letters.
std::string interval_cell(const Interval& interval, Footnotes& notes, double scale = 1, const std::string& unit = {}) {
    if (!std::isfinite(interval.value)) return "&ndash;" + notes.sign(interval.note);
    std::string html = figure(interval.value * scale) + unit + notes.sign(interval.note);
    if (std::isfinite(interval.low) && std::isfinite(interval.high))
        html += " <span class=\"range\">[" + figure(interval.low * scale) + ", " + figure(interval.high * scale) +
                "]</span>";
    return html;
}

bool shown(const Curve& curve, const std::string& scene, const std::string& channel, const std::string& region) {
    return curve.scene == scene && curve.channel == channel && curve.region == region;
}

/// Returns a time as text.
std::string time_text(double seconds) {
    return seconds < 60 ? number_text(seconds) + " s" : duration_text(seconds);
}

std::string seconds_html(const TimeToError& time, Footnotes& notes) {
    const Interval& s = time.seconds;
    if (!std::isfinite(s.value)) return "&ndash;" + notes.sign(s.note);
    std::string html = time_text(s.value) + (time.extrapolated ? " &dagger;" : "") + notes.sign(s.note);
    if (std::isfinite(s.low) && std::isfinite(s.high))
        html += " <span class=\"range\">[" + (s.high < 60 ? number_text(s.low) : time_text(s.low)) + ", " +
                (s.high < 60 ? number_text(s.high) : time_text(s.high)) + "]</span>";
    return html;
}

const TimeToError* time_to_one_percent(const Standing& standing) {
    if (standing.curve == nullptr) return nullptr;
    const std::vector<TimeToError>& times = standing.curve->times;
    const auto found =
        std::find_if(times.begin(), times.end(), [](const auto& time) { return time.relative_error == 0.01; });
    return found == times.end() ? nullptr : &*found;
}

/// Returns a cell with the error, and below it the time to 1 %, or the error reached.
std::string standing_cell(const Standing& standing, bool best, double least_time, Footnotes& notes) {
    const TimeToError* time = time_to_one_percent(standing);
    if (time == nullptr || !std::isfinite(standing.squared.value)) return cell("&ndash;");
    const auto marked = [](const std::string& html, bool bold) { return bold ? "<b>" + html + "</b>" : html; };
    Interval error = standing.squared;
    for (double* each : {&error.value, &error.low, &error.high})
        if (!std::isnan(*each)) *each = relative_error(*each);
    const BudgetPoint& last = standing.curve->points.back();
    std::string html =
        marked(interval_cell(error, notes, 100, " %" + std::string(standing.extrapolated ? " &dagger;" : "")), best);
    if (std::isfinite(time->seconds.value))
        html += "1 % in " + marked(seconds_html(*time, notes), time->seconds.value == least_time);
    else
        html += "1 % not reached" + notes.sign(time->seconds.note) + ", " + percent_text(last.relative.value) +
                " after " + time_text(last.seconds);
    return cell(html);
}

std::string slope_cell(const SlopeTest& slope, Footnotes& notes) {
    const std::optional<Line>& line = slope.checked();
    if (!line) return cell("&ndash;");
    return cell(figure(line->slope) + notes.sign(slope.samples ? "" : "against seconds without setup") +
                " <span class=\"range\">[" + figure(line->slope_low) + ", " + figure(line->slope_high) + "]</span>");
}

std::string speed_up_cell(const Curve& curve, Footnotes& notes) {
    return curve.first ? cell("1" + notes.sign("the variant that others are compared with"))
                       : cell(interval_cell(curve.speed_up, notes));
}

}  // namespace

std::string comparison_table(const Study& study) {
    if (study.comparisons.empty()) return {};
    Footnotes notes;
    std::string head = "<th>Channel</th><th>Time</th>", rows, scene;
    for (const MethodVariant& variant : study.variants) head += "<th>" + escape_html(variant.name) + "</th>";
    for (const MethodComparison& each : study.comparisons) {
        if (each.scene != scene && study.experiment->scenes.size() > 1)
            rows += row("<th colspan=\"" + std::to_string(study.variants.size() + 3) + "\">" + escape_html(each.scene) +
                        "</th>");
        scene = each.scene;
        double least = std::numeric_limits<double>::infinity();
        for (const Standing& standing : each.standings)
            if (const TimeToError* time = time_to_one_percent(standing); time != nullptr && time->seconds.value < least)
                least = time->seconds.value;
        std::string cells = text_cell(each.channel) + cell(time_text(each.seconds));
        for (std::size_t i = 0; i < each.standings.size(); ++i)
            cells += standing_cell(each.standings[i], each.measured > 1 && i == each.best,
                                   each.measured > 1 ? least : 0, notes);
        rows += row(cells + text_cell(best_sentence(study, each)));
    }
    return "<div class=\"first\">" + table(head + "<th>Best</th>", rows) + "</div>\n" +
           notes.legend(
               "Relative error at the largest time that all methods of a row reached, and the time to 1 %. Bold: the "
               "smallest. &dagger; extrapolated beyond the measured times.");
}

std::string times_table(const Study& study, const std::string& scene, const std::string& channel,
                        const std::string& region) {
    Footnotes notes;
    bool extrapolated = false;
    std::string head = "<th>Time to a relative error of</th>", rows;
    for (const double target : target_errors) head += "<th>" + percent_text(target) + "</th>";
    head +=
        formula_header("Speed-up", "efficiency / efficiency of the first; efficiency = 1 / (relmse-mean x seconds)");
    for (const Curve& curve : study.curves) {
        if (!shown(curve, scene, channel, region)) continue;
        std::string cells = text_cell(curve.variant);
        for (const TimeToError& time : curve.times) {
            cells += cell(seconds_html(time, notes), time.extrapolated ? "number extrapolated" : "number");
            extrapolated = extrapolated || time.extrapolated;
        }
        rows += row(cells + speed_up_cell(curve, notes));
    }
    return table(head, rows) + notes.legend(extrapolated ? "&dagger; extrapolated beyond the measured times." : "");
}

std::string errors_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region) {
    Footnotes notes;
    std::string head = "<th>Variant</th><th>Largest budget</th><th>CPU seconds</th><th>Wall seconds</th>" +
                       formula_header("relative error",
                                      std::string("sqrt(relmse-mean)") + (study.noise_subtracted(scene, channel, region)
                                                                              ? ", the reference's noise subtracted"
                                                                              : ""));
    for (const display::ErrorMetricInfo& each : display::error_metrics())
        head += formula_header(each.name, each.formula);
    for (const display::ImageMetric each : seen_metrics)
        head += formula_header(display::info_of(each).name, display::info_of(each).formula);
    head += formula_header("trimmed away", "share of relmse-mean's sum") +
            formula_header("share of the reference", "mean(Var(b) / (b^2 + (0.1 m)^2))");
    std::string rows;
    for (const Curve& curve : study.curves) {
        if (!shown(curve, scene, channel, region) || curve.points.empty()) continue;
        const BudgetPoint& point = curve.points.back();
        std::string cells = text_cell(curve.variant) + cell(spoken_budget(curve.budget_kind, point.budget)) +
                            cell(figure(point.cpu_seconds)) + cell(figure(point.wall_seconds)) +
                            cell(interval_cell(point.relative, notes, 100, " %"));
        std::array<double, display::error_metric_count + seen_metrics.size()> sums{};
        double trimmed = 0, count = 0;
        for (const RunErrors& each : study.runs) {
            if (each.run->scene != scene || each.variant != curve.variant || each.channel != channel ||
                each.region != region || each.run->budget != point.budget)
                continue;
            for (std::size_t i = 0; i < display::error_metric_count; ++i) sums[i] += each.measures.values[i];
            for (std::size_t i = 0; i < seen_metrics.size(); ++i) sums[display::error_metric_count + i] += each.seen[i];
            trimmed += each.measures.trimmed_share;
            count += 1;
        }
        for (const double sum : sums) cells += cell(figure(sum / count));
        rows += row(cells + cell(percent_text(trimmed / count)) + cell(figure(point.excess)));
    }
    return table(head, rows) + notes.legend();
}

std::string slopes_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region) {
    std::string rows;
    Footnotes notes;
    const std::string heavy = std::string("; ") + heavy_tail_note;
    for (const Curve& curve : study.curves) {
        if (!shown(curve, scene, channel, region)) continue;
        std::string text = curve.slope.text;
        const bool tail = text.ends_with(heavy);
        if (tail) text.resize(text.size() - heavy.size());
        rows += row(text_cell(curve.variant) + slope_cell(curve.slope, notes) + "<td class=\"" +
                    (curve.slope.too_shallow ? "fails" : "note") + "\">" + escape_html(text) +
                    notes.sign(tail ? heavy_tail_note : "") + "</td>");
    }
    return table("<th>Variant</th>" +
                     formula_header("Slope over the last 4 octaves", "d log relmse-mean / d log samples") +
                     "<th>Verdict</th>",
                 rows) +
           notes.legend();
}

std::string front_table(const Study& study, const std::string& scene, const std::string& channel) {
    std::string rows;
    Footnotes notes;
    int place = 0;
    for (const FrontPoint& each : front_of(study, scene, channel))
        rows +=
            row(cell(std::to_string(++place)) + text_cell(each.curve->variant) +
                cell(spoken_budget(each.curve->budget_kind, each.point->budget)) +
                cell(duration_text(each.point->seconds)) + cell(interval_cell(each.point->relative, notes, 100, " %")));
    return table("<th></th><th>Variant</th><th>Budget</th><th>Time</th><th>Relative error</th>", rows) + notes.legend();
}

std::string effects_table(const Study& study, const SceneInfo& scene) {
    // One row per change, one column per channel.
    std::vector<std::array<std::string, 4>> changes;
    std::map<std::pair<std::size_t, std::string>, const SettingEffect*> found;
    for (const SettingEffect& effect : study.effects) {
        if (effect.scene != scene.name) continue;
        const std::array<std::string, 4> change{effect.key, effect.from, effect.to, effect.others};
        const auto known = std::find(changes.begin(), changes.end(), change);
        found[{static_cast<std::size_t>(known - changes.begin()), effect.channel}] = &effect;
        if (known == changes.end()) changes.push_back(change);
    }
    if (changes.empty()) return {};
    Footnotes notes;
    std::string head = "<th>Setting</th><th>Change</th><th>With</th>", rows;
    for (const ChannelInfo& channel : scene.channels) head += "<th>" + escape_html(channel.name) + "</th>";
    for (std::size_t i = 0; i < changes.size(); ++i) {
        const auto& [key, from, to, others] = changes[i];
        std::string cells =
            "<td><code>" + escape_html(key) + "</code></td>" + text_cell(from + " to " + to) + text_cell(others);
        for (const ChannelInfo& channel : scene.channels) {
            const auto effect = found.find({i, channel.name});
            if (effect == found.end()) {
                cells += cell("&ndash;");
                continue;
            }
            const Interval& ratio = effect->second->speed_up;
            const bool better = ratio.valid() && ratio.low > 1, worse = ratio.valid() && ratio.high < 1;
            cells += cell((better  ? "<span class=\"holds\">pays</span> "
                           : worse ? "<span class=\"fails\">costs</span> "
                                   : std::string()) +
                          interval_cell(ratio, notes) + "<br><span class=\"range\">medians " +
                          figure(effect->second->by_medians) + "</span>");
        }
        rows += row(cells);
    }
    return "<p class=\"note\">Speed-up: the ratio of 1 / (relmse-mean x seconds) at the largest budgets, for every "
           "channel. Pays or costs: the interval is above or below 1. Medians: the ratio of medians over replicates, "
           "which a few fireflies do not change.</p>\n" +
           table(head, rows) + notes.legend();
}

std::string predictions_text(const Study& study) {
    std::vector<double> off;
    for (const Curve& curve : study.curves) {
        const auto variant = std::find_if(study.variants.begin(), study.variants.end(),
                                          [&](const MethodVariant& each) { return each.name == curve.variant; });
        if (curve.prediction && curve.region.empty() && variant->unbiased)
            off.push_back(std::abs(curve.prediction->relative_difference()));
    }
    if (off.empty())
        return "<p class=\"faint\">No curve of a method declared unbiased has the three budgets that a prediction "
               "needs.</p>\n";
    std::sort(off.begin(), off.end());
    const double median = off[off.size() / 2];
    return "<p>The time to the error of every curve's last budget was predicted from its earlier budgets. The "
           "prediction is off by " +
           percent_text(median) + " in the median and " + percent_text(off.back()) + " at worst, over " +
           std::to_string(off.size()) + " curves of methods declared unbiased.</p>\n";
}

std::string counterexample_list(const Study& study, const SceneInfo& scene) {
    std::string html;
    for (const CounterexampleEntry& entry : study.words) {
        if (entry.scene != scene.name) continue;
        const Counterexamples::Counterexample* first = first_counterexample(study, scene.name, entry.variant);
        if (first == nullptr && entry.first.notes.empty()) continue;
        html += "<p><b>" + escape_html(entry.variant) + "</b> ";
        if (first != nullptr) {
            html += "is first wrong at the path <code>" + escape_html(first->text) + "</code> (" +
                    escape_html(first->sentence) + "), the shortest one in channel <code>" +
                    escape_html(first->channel) + "</code>, or at a longer one of that channel";
            const char* before = "; further <code>";
            for (const Counterexamples::Counterexample& word : entry.first.words) {
                if (&word == first) continue;
                html += before + escape_html(word.text) + "</code> in " + escape_html(word.channel);
                before = ", <code>";
            }
            html += ".";
        }
        for (const std::string& note : entry.first.notes)
            html += " <span class=\"note\">" + escape_html(note) + ".</span>";
        html += "</p>\n";
    }
    return html;
}

namespace {

/// Returns the budget of a bias verdict with its unit.
std::string bias_budget(const Study& study, const BiasEntry& entry) {
    const Curve* curve = study.curve(entry.scene, entry.variant, entry.channel);
    return curve != nullptr ? spoken_budget(curve->budget_kind, entry.budget) : number_text(entry.budget, 6);
}

}  // namespace

std::string bias_table(const Study& study, const SceneInfo& scene) {
    std::string rows;
    Footnotes notes;
    for (const BiasEntry& entry : study.bias) {
        if (entry.scene != scene.name) continue;
        const BiasTest& v = entry.result;
        std::string cells = text_cell(entry.variant) + text_cell(entry.channel) +
                            cell(std::to_string(entry.replicates)) + cell(bias_budget(study, entry));
        if (!v.tested) {
            rows += row(cells + "<td class=\"note\">not tested</td><td></td><td></td><td></td><td></td><td></td>" +
                        text_cell(v.note));
            continue;
        }
        const BiasConclusion conclusion = entry.conclusion();
        const char* type = conclusion == BiasConclusion::differs       ? "fails"
                           : conclusion == BiasConclusion::none_found  ? "holds"
                           : conclusion == BiasConclusion::omits_paths ? "note"
                                                                       : "warn";
        cells += "<td class=\"" + std::string(type) + "\">" + escape_html(result_of(study, entry)) + "</td>";
        cells += cell(figure(v.adjusted_p, 2)) + cell(interval_cell(v.mean_difference, notes, 100, " %"));
        cells += cell(block_text(study, entry) + ", " + interval_cell(v.worst_difference, notes, 100, " %"));
        cells += cell(percent_text(v.detectable_whole)) + cell(percent_text(v.detectable_block));
        const std::string against =
            entry.against.empty() ? "" : "compared with " + entry.against + ", because it made the reference itself. ";
        rows += row(cells + text_cell(against + v.note));
    }
    if (rows.empty()) return "<p class=\"faint\">Nothing could be tested.</p>\n";
    return table("<th>Variant</th><th>Channel</th><th>Replicates</th><th>Budget of each</th><th>Verdict</th>" +
                     formula_header("p, corrected", "2 (1 - (1 - p)^tests), separately for whole images and blocks") +
                     formula_header("Difference of the mean", "mean(a) / mean(b) - 1") + "<th>Most significant</th>" +
                     formula_header("Bias found with 90 %, whole", "(t_(a'/2) + t_90%) s / sqrt(n) / mean(b)") +
                     formula_header("in a median block", "likewise for blocks of 16 x 16 pixels") + "<th></th>",
                 rows) +
           "<p class=\"note\">Intervals are at the level of their test. Cannot tell: a bias of " +
           percent_text(largest_hidden_bias) + " of the mean would be missed, or only the reference supports " +
           "the method that made it.</p>\n" + notes.legend();
}

}  // namespace raylex::experiments
