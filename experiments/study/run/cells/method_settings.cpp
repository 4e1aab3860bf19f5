#include "experiments/study/run/cells/method_settings.h"

#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

/// Adds NAME.type and NAME.PARAMETER, the keys of a sweep.
void add_entity(NamedValues& values, const std::string& name, const transport::SceneEntity& entity) {
    values.emplace_back(name + ".type", entity.type);
    for (const Parameter& each : entity.parameters.parameters) {
        std::string text;
        for (const double number : each.numbers) text += (text.empty() ? "" : " ") + number_text(number, 17);
        for (const std::string& word : each.strings) text += (text.empty() ? "" : " ") + word;
        for (const std::uint8_t flag : each.booleans)
            text += std::string(text.empty() ? "" : " ") + (flag != 0 ? "true" : "false");
        values.emplace_back(name + "." + each.name, text);
    }
}

}  // namespace

NamedValues settings_text(const transport::RenderSettings& settings, const transport::EffectChoices& effects,
                          const std::vector<PassRequest>& passes) {
    NamedValues values;
    if (settings.paths.integrator) add_entity(values, "integrator", *settings.paths.integrator);
    for (std::size_t i = 0; i < passes.size(); ++i) {
        const std::string name = "passes." + std::to_string(i + 1);
        add_entity(values, name, passes[i].method);
        values.emplace_back(name + ".takes", passes[i].takes);
        if (!passes[i].name.empty()) values.emplace_back(name + ".name", passes[i].name);
        if (passes[i].has_aovs) values.emplace_back(name + ".aovs", "on");
        values.emplace_back(name + ".spp", std::to_string(passes[i].samples_per_pixel.value_or(1)));
        values.emplace_back(name + ".share", number_text(passes[i].time_share, 17));
    }
    if (settings.samples.sampler) add_entity(values, "sampler", *settings.samples.sampler);
    if (settings.film.filter) add_entity(values, "filter", *settings.film.filter);
    if (!settings.channels.beauty) values.emplace_back("beauty", "off");
    if (!settings.paths.prune) values.emplace_back("prune", "off");
    for (const transport::EffectInfo& each : transport::effect_catalogue())
        if (const std::optional<bool>& forced = effects[each.effect])
            values.emplace_back("effects." + std::string(each.name), *forced ? "on" : "off");
    if (settings.paths.max_depth) values.emplace_back("max_depth", std::to_string(*settings.paths.max_depth));
    values.emplace_back("filter_mode", settings.film.splat ? "splat" : "importance");
    values.emplace_back("lobes", settings.labels.picked_lobes ? "picked" : "exact");
    const auto& filters = settings.channels.sample_filters;
    for (std::size_t i = 0; i < filters.size(); ++i)
        add_entity(values, filters.size() == 1 ? "sample_filter" : "sample_filter." + std::to_string(i + 1),
                   filters[i]);
    return values;
}

}  // namespace raylex::experiments
