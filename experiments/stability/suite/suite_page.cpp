#include "experiments/stability/suite/suite_page.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/stability/suite/suite_chart.h"
#include "lpe/input/read_input.h"
#include "transport/math/real.h"

namespace raylex::experiments {
namespace {

std::string cell(const std::string& text, bool number = true) {
    return std::string(number ? "<td class=\"number\">" : "<td>") + escape_html(text) + "</td>";
}

std::string result_cell(const LineResult& line) {
    const bool good = line.result == LineState::holds;
    const char* const words[] = {"holds", "fails", "died", "not applicable"};
    return std::string("<td><span class=\"") + (good ? "holds" : "fails") + "\">" +
           words[static_cast<std::size_t>(line.result)] + "</span></td>";
}

std::string rows_text(const std::vector<int>& rows) {
    std::string text;
    for (const int row : rows) text += (text.empty() ? "" : ", ") + std::to_string(row);
    return text;
}

class PageWriter {
  public:
    explicit PageWriter(const SuitePage& page) : page_(page) {
        for (const LineResult& line : page.results->lines) lines_[line.name].push_back(line);
        if (page.baseline != nullptr)
            for (const LineResult& line : page.baseline->results.lines) baseline_[line.name][line.setting] = line;
    }

    std::string html() const {
        std::string body = summary() + scenes();
        for (const CaseFamily& family : *page_.families) body += section(family);
        return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
               "content=\"width=device-width, initial-scale=1\">\n<title>Hard cases</title>\n<style>" +
               std::string(page_style()) +
               "svg { display: block; width: 100%; max-width: 60rem; height: auto; margin: .4rem 0 .8rem; }\n"
               ".pair { display: flex; flex-wrap: wrap; gap: 1rem 2rem; align-items: flex-start; }\n"
               ".pair img { max-width: 22rem; width: 100%; image-rendering: pixelated; border-radius: 8px; }\n"
               ".pair > svg { flex: 1 1 34rem; }\n</style>\n</head>\n<body>\n<h1>Hard cases: what stays numerically "
               "stable</h1>\n" +
               body + "</body>\n</html>\n";
    }

  private:
    std::string summary() const {
        const SuiteResults& results = *page_.results;
        const std::size_t absent = results.count(LineState::not_applicable), good = results.count(LineState::holds),
                          bad = results.lines.size() - good - absent;
        std::string html =
            "<p><span class=\"" + std::string(bad == 0 ? "holds" : "fails") + "\">" +
            (bad == 0 ? "Every line holds" : counted(bad, "line does", "lines do") + " not hold") +
            "</span>: " + std::to_string(good) + " of " + std::to_string(good + bad) + " lines of " +
            counted(lines_.size() - absent, "case") + " hold" +
            (absent > 0
                 ? "; " + counted(absent, "case needs a feature", "cases need features") + " that raylex does not have"
                 : "") +
            ".</p>\n<p class=\"faint\">" +
            escape_html("raylex " + raylex_version() + " (" + raylex_revision() + "), " + build_description() +
                        ", arithmetic in " + (transport::real_is_double ? "double" : "float") + ", " +
                        host_description() + "; " + utc_time() + ", " + duration_text(results.seconds)) +
            "</p>\n";
        if (bad == 0) return html;
        html += "<ul>\n";
        for (const LineResult& line : results.lines)
            if (line.result == LineState::fails || line.result == LineState::died)
                html += "<li><a href=\"#case-" + escape_html(line.name) + "\">" + escape_html(line.name) + "</a> " +
                        escape_html(line.setting) + "</li>\n";
        return html + "</ul>\n";
    }

    /// Returns the table of whole scenes rendered by both programs, and the times of the suite.
    std::string scenes() const {
        if (page_.baseline == nullptr) return {};
        const BaselineRun& baseline = *page_.baseline;
        double mine = 0, theirs = 0;
        std::size_t failing = 0;
        for (const auto& [name, lines] : lines_)
            for (const LineResult& line : lines) {
                const auto known = baseline_.find(name);
                if (known == baseline_.end()) continue;
                const auto other = known->second.find(line.setting);
                if (other == known->second.end()) continue;
                mine += line.seconds;
                theirs += other->second.seconds;
                failing += other->second.result == LineState::holds ? 0 : 1;
            }
        std::string html = "<h2>Comparison with " + escape_html(baseline.name) + "</h2>\n<p>The same lines take " +
                           number_text(theirs / mine) + " times as long in that program; " +
                           (failing == 0 ? "all hold too" : counted(failing, "line does", "lines do") + " not hold") +
                           ". Its results are the hollow dots, and a column of each case.</p>\n";
        if (baseline.scenes.empty()) return html;
        html +=
            "<p>Whole scenes with the same random numbers, so that the images differ by arithmetic instead of noise; "
            "CPU time is the minimum of several alternating runs.</p>\n<div class=\"wide\"><table><tr><th>scene</th>"
            "<th>relmse between the images</th><th>mean of this / that - 1</th><th>CPU seconds</th><th>there</th>"
            "<th>ratio</th></tr>\n";
        for (const SceneDifference& each : baseline.scenes)
            html += "<tr>" + cell(each.scene, false) + cell(number_text(each.relative_mse)) +
                    cell(number_text(each.mean_ratio - 1)) + cell(number_text(each.cpu_seconds)) +
                    cell(number_text(each.baseline_cpu_seconds)) +
                    cell(number_text(each.baseline_cpu_seconds / each.cpu_seconds)) + "</tr>\n";
        return html + "</table></div>\n";
    }

    std::string section(const CaseFamily& family) const {
        std::vector<LineResult> all, other;
        std::string cases;
        for (const StabilityCase& each : family.cases) {
            const auto found = lines_.find(each.name);
            if (found == lines_.end()) continue;
            all.insert(all.end(), found->second.begin(), found->second.end());
            if (const auto baseline = baseline_.find(each.name); baseline != baseline_.end())
                for (const auto& [setting, line] : baseline->second) other.push_back(line);
            cases += each.not_applicable.empty() ? described(each, found->second) : absent(each);
        }
        if (all.empty()) return {};
        std::string picture;
        if (auto png = read_input(page_.pictures + "/" + family.name + ".png", NamedBy::file, "a picture"); png)
            picture = "<img alt=\"" + escape_html(family.picture) + "\" src=\"" +
                      data_uri({reinterpret_cast<const unsigned char*>(png->data()), png->size()}) + "\">";
        return "<h2>" + escape_html(family.title) + "</h2>\n<p>" + escape_html(family.about) +
               "</p>\n<div class=\"pair\">" + suite_chart(all, other) + picture + "</div>\n" + cases;
    }

    static std::string absent(const StabilityCase& each) {
        return "<p><b>" + escape_html(each.name) + "</b> <span class=\"faint\">(row " + rows_text(each.rows) +
               ")</span> " + escape_html(each.symptom) + " <i>Not applicable: " + escape_html(each.not_applicable) +
               "</i></p>\n";
    }

    std::string described(const StabilityCase& each, const std::vector<LineResult>& lines) const {
        const auto bad = std::count_if(lines.begin(), lines.end(),
                                       [](const LineResult& line) { return line.result != LineState::holds; });
        const auto baseline = baseline_.find(each.name);
        std::string html = "<details id=\"case-" + escape_html(each.name) + "\"" + (bad > 0 ? " open" : "") +
                           "><summary>" + escape_html(each.name) + " <span class=\"faint\">" +
                           (each.rows.empty() ? "" : "row " + rows_text(each.rows) + ", ") +
                           counted(lines.size(), "line") + "</span>" +
                           (bad > 0 ? " <span class=\"fails\">" + std::to_string(bad) + " not</span>" : "") +
                           "</summary>\n<p>" + escape_html(each.symptom) + "</p>\n<p class=\"faint\">Tolerance " +
                           escape_html(each.tolerance.text) + ": " + escape_html(each.reason) +
                           (each.source.empty() ? "" : " Source: " + escape_html(each.source)) +
                           "</p>\n<div class=\"wide\"><table><tr><th></th><th>expected</th><th>measured</th>"
                           "<th>error</th><th>allowed</th><th></th><th>seconds</th>" +
                           (baseline == baseline_.end()
                                ? ""
                                : "<th>error in " + escape_html(page_.baseline->name) + "</th><th>seconds</th>") +
                           "<th></th></tr>\n";
        for (const LineResult& line : lines) {
            html += "<tr>" + cell(line.setting, false) + cell(number_text(line.expected, 9)) +
                    cell(number_text(line.measured, 9)) + cell(line.error_text()) + cell(number_text(line.allowed)) +
                    result_cell(line) + cell(number_text(line.seconds));
            if (baseline != baseline_.end()) {
                const auto other = baseline->second.find(line.setting);
                const bool known = other != baseline->second.end();
                html += cell(known ? number_text(other->second.error) : "") +
                        cell(known ? number_text(other->second.seconds) : "");
            }
            html += cell(line.note, false) + "</tr>\n";
        }
        return html + "</table></div></details>\n";
    }

    const SuitePage& page_;
    std::map<std::string, std::vector<LineResult>> lines_;
    std::map<std::string, std::map<std::string, LineResult>> baseline_;
};

}  // namespace

std::string suite_page(const SuitePage& page) {
    return PageWriter(page).html();
}

}  // namespace raylex::experiments
