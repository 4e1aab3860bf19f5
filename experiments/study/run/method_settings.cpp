#include "experiments/study/run/method_settings.h"

#include "experiments/cli/console.h"

namespace raylex::experiments {
namespace {

/// "path(strategy=mis)".
std::string entity_text(const transport::SceneEntity& entity) {
    std::string text = entity.type;
    for (const Parameter& each : entity.parameters.parameters) {
        text += (text.size() == entity.type.size() ? "(" : ", ") + each.name + "=";
        std::string values;
        for (const double number : each.numbers) values += (values.empty() ? "" : " ") + number_text(number, 17);
        for (const std::string& word : each.strings) values += (values.empty() ? "" : " ") + word;
        for (const std::uint8_t flag : each.booleans)
            values += std::string(values.empty() ? "" : " ") + (flag != 0 ? "true" : "false");
        text += values;
    }
    return text.size() == entity.type.size() ? text : text + ")";
}

}  // namespace

NamedValues settings_text(const transport::RenderSettings& settings) {
    NamedValues values;
    if (settings.integrator) values.emplace_back("integrator", entity_text(*settings.integrator));
    if (settings.sampler) values.emplace_back("sampler", entity_text(*settings.sampler));
    if (settings.filter) values.emplace_back("filter", entity_text(*settings.filter));
    if (settings.max_depth) values.emplace_back("max_depth", std::to_string(*settings.max_depth));
    if (settings.splat) values.emplace_back("filter_mode", "splat");
    if (settings.picked_lobes) values.emplace_back("lobes", "picked");
    std::string filters;
    for (const transport::SceneEntity& each : settings.sample_filters)
        filters += (filters.empty() ? "" : ", ") + entity_text(each);
    if (!filters.empty()) values.emplace_back("sample_filter", filters);
    return values;
}

}  // namespace raylex::experiments
