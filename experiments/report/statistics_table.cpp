#include "experiments/report/statistics_table.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "experiments/job/text/json.h"
#include "experiments/report/html.h"

namespace raylex::experiments {
namespace {

double number_at(const Json& json, const char* pointer) {
    const Json::json_pointer path(pointer);
    return json.contains(path) && json.at(path).is_number() ? json.at(path).get<double>() : 0.0;
}

std::string text_of(const char* format, double value) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

/// 1234567 as "1 234 567".
std::string grouped_digits(double value) {
    std::string digits = text_of("%.0f", value);
    for (std::ptrdiff_t at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
        digits.insert(static_cast<std::size_t>(at), " ");
    return digits;
}

std::string row(const std::string& name, const std::string& value) {
    return "<tr><td>" + name + "</td><td class=\"number\">" + value + "</td></tr>\n";
}

/// Which effects were simulated, and why.
std::string effects(const Json& json) {
    const auto found = json.find("effects");
    if (found == json.end() || !found->is_object()) return {};
    std::string table = "<div class=\"wide\"><table>\n<tr><th>Effect</th><th>Simulated</th><th>Why</th></tr>\n";
    for (const auto& [name, each] : found->items()) {
        if (!each.is_object()) continue;
        const Json forced = each.value("forced", Json());
        table += "<tr><td>" + escape_html(name) + "</td><td>" + (each.value("simulated", false) ? "yes" : "no") +
                 (forced.is_boolean() ? (forced.get<bool>() ? ", forced on" : ", forced off") : "") + "</td><td>" +
                 escape_html(each.value("why", std::string())) + "</td></tr>\n";
    }
    return table + "</table></div>\n";
}

std::string phases(const Json& json) {
    std::string table =
        "<div class=\"wide\"><table>\n<tr><th>Phase</th><th>Wall seconds</th><th>CPU seconds</th></tr>\n";
    for (const std::string phase : {"load", "plan", "build", "prepare", "render", "write"}) {
        const std::string at = "/phases/" + phase;
        table += "<tr><td>" + phase + "</td><td class=\"number\">" +
                 text_of("%.3f", number_at(json, (at + "/wall_seconds").c_str())) + "</td><td class=\"number\">" +
                 text_of("%.3f", number_at(json, (at + "/cpu_seconds").c_str())) + "</td></tr>\n";
    }
    return table + "</table></div>\n";
}

/// The shares of path lengths, with bars.
std::string path_lengths(const Json& json) {
    const auto found = json.find("path_length_histogram");
    if (found == json.end() || !found->is_array()) return {};
    double total = 0;
    for (const Json& each : *found) total += each.is_number() ? each.get<double>() : 0;
    if (!(total > 0)) return {};
    std::string table = "<div class=\"wide\"><table>\n<tr><th>Scattering events</th><th>Paths</th><th></th></tr>\n";
    for (std::size_t i = 0; i < found->size(); ++i) {
        const double share = (*found)[i].is_number() ? (*found)[i].get<double>() / total : 0;
        table += "<tr><td>" + std::to_string(i) + "</td><td class=\"number\">" + text_of("%.2f %%", share * 100) +
                 "</td><td><div style=\"height:.7em;background:var(--mark);width:" +
                 text_of("%.1f", std::max(share * 16, 0.0)) + "rem\"></div></td></tr>\n";
    }
    return table + "</table></div>\n";
}

}  // namespace

std::string statistics_table(const std::string& record) {
    Json json;
    try {
        json = parse_json(record);
    } catch (const Json::exception&) { return {}; }
    if (!json.is_object() || !json.contains("phases")) return {};
    std::string text = "<div class=\"tables\">\n" + phases(json) + "<div class=\"wide\"><table>\n";
    text += row("Camera samples", grouped_digits(number_at(json, "/samples/camera")));
    text += row("Samples per CPU second", grouped_digits(number_at(json, "/samples/per_cpu_second")));
    text += row("Camera rays", grouped_digits(number_at(json, "/rays/camera")));
    text += row("Scattering rays", grouped_digits(number_at(json, "/rays/scattering")));
    text += row("Shadow rays", grouped_digits(number_at(json, "/rays/shadow")));
    if (const double count = number_at(json, "/branches"); count > 0)
        text += row("Rays of split paths", grouped_digits(count));
    if (const double count = number_at(json, "/rays/pilot"); count > 0)
        text += row("Rays traced before the render, to tune sampling", grouped_digits(count));
    const std::pair<const char*, const char*> pruned[] = {
        {"Paths ended: no layer uses what could follow", "/pruned/paths"},
        {"Light samples not drawn: no layer uses them", "/pruned/light_samples"},
        {"Shadow rays not traced: no layer uses their light", "/pruned/shadow_rays"},
        {"Last rays replaced by light samples", "/pruned/rays_left_to_light_samples"},
        {"Light samples left out at random", "/pruned/light_samples_left_to_rays"},
        {"Lobes not sampled: no layer uses that side of the surface", "/pruned/lobes"},
        {"Light paths not started or ended early: no layer uses them", "/pruned/light_paths"},
        {"Connections to light paths not made: no layer uses them", "/pruned/joins"},
        {"Paths ended by roulette: layers receive little of them", "/pruned/weak_paths"},
        {"Materials not evaluated: layers need only the geometry of first hits", "/pruned/closures"}};
    for (const auto& [label, place] : pruned)
        if (const double count = number_at(json, place); count > 0) text += row(label, grouped_digits(count));
    if (number_at(json, "/guide/paid/image_share") > 0) {
        const auto percent = [&](const char* place) { return text_of("%.0f %%", 100 * number_at(json, place)); };
        text += row("Path guiding: forecast gain", text_of("%.3g", number_at(json, "/guide/forecast_gain")));
        text += row("Path guiding: used in this share of its regions", percent("/guide/guided_share"));
        text += row("Path guiding: used in this share of the image", percent("/guide/paid/image_share"));
    }
    text += row("Merged attributions", grouped_digits(number_at(json, "/attribution_overflow")));
    text += row("Contributions that are not finite", grouped_digits(number_at(json, "/invalid_samples/count")));
    text += row("Peak memory", text_of("%.0f MB", number_at(json, "/peak_memory_bytes") * 1e-6));
    text += "</table></div>\n" + path_lengths(json) + effects(json) + "</div>\n";
    const auto warnings = json.find("warnings");
    if (warnings != json.end() && warnings->is_array() && !warnings->empty()) {
        text += "<p>Warnings:</p>\n<ul>\n";
        for (const Json& each : *warnings)
            if (each.is_string()) text += "<li>" + escape_html(each.get<std::string>()) + "</li>\n";
        text += "</ul>\n";
    }
    return text;
}

}  // namespace raylex::experiments
