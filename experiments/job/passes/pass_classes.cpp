#include "experiments/job/passes/pass_classes.h"

#include "lpe/algebra/proofs/paths.h"
#include "transport/integrators/integrator.h"
#include "transport/integrators/omitted_paths.h"

namespace raylex::experiments {
namespace {

/// The expression in parentheses. A comment in it ends with its line.
std::string enclosed(const std::string& expression) {
    return "(" + expression + (expression.find('#') == std::string::npos ? ")" : "\n)");
}

std::string both(const std::string& a, const std::string& b) {
    return enclosed(a) + "&" + enclosed(b);
}

/// What a method omits in a scene, in the dialect renderman.
std::vector<std::string> omitted_by(const std::string& method, const transport::SceneEntity& entity,
                                    const transport::SceneDescription& scene) {
    transport::SceneEntity named = entity;
    named.type = method;
    std::vector<std::string> expressions;
    for (const transport::OmittedPaths& each : transport::omitted_paths(named, scene))
        if (each.dialect == lpe::Dialect::renderman) expressions.push_back(each.expression);
    return expressions;
}

Result<std::optional<lpe::Witness>> path_in(const std::string& expression, const lpe::PathStrings& words) {
    return lpe::find_path_string(lpe::ChannelSource{.expression = expression}, words);
}

}  // namespace

std::pair<std::string, std::string> split_prefixes(const std::string& expression) {
    bool quoted = false;
    std::size_t end = 0;
    for (std::size_t i = 0; i < expression.size(); ++i) {
        if (quoted && expression[i] == '\\') ++i;
        else if (expression[i] == '\'') quoted = !quoted;
        else if (expression[i] == ';' && !quoted) end = i + 1;
    }
    if (end == 0 && expression.starts_with("lpe:")) end = 4;
    return {expression.substr(0, end), expression.substr(end)};
}

std::string any_path_of(const std::vector<std::string>& expressions) {
    if (expressions.size() == 1) return expressions.front();
    std::string text;
    for (const std::string& each : expressions) text += (text.empty() ? "" : "|") + enclosed(each);
    return text;
}

std::string paths_without(const std::string& whole, const std::vector<std::string>& others) {
    return others.empty() ? whole : enclosed(whole) + "-" + enclosed(any_path_of(others));
}

display::ChannelDefinition channel_within(const display::ChannelDefinition& channel,
                                          const std::vector<display::ChannelDefinition>& channels,
                                          const std::string& of_class) {
    display::ChannelDefinition part = channel;
    part.rest_of.clear();
    if (channel.rest_of.empty()) {
        const auto [prefixes, language] = split_prefixes(channel.expression);
        part.expression = prefixes + both(language, of_class);
        return part;
    }
    std::vector<std::string> members;
    for (const std::size_t member : channel.rest_of)
        members.push_back(split_prefixes(channels[member].expression).second);
    part.expression = both(paths_without("C.*", members), of_class);
    return part;
}

Result<std::optional<MissedPath>> find_missed_path(const std::string& of_class, const transport::SceneEntity& method,
                                                   const transport::SceneDescription& scene,
                                                   const lpe::PathStrings& words) {
    auto chosen = transport::choose_integrator(method, std::nullopt);
    if (!chosen) return chosen.error();
    for (const transport::OmittedPaths& declared : transport::omitted_paths(chosen->name)) {
        if (declared.dialect == lpe::Dialect::renderman || chosen->name == "lighttracer") continue;
        const lpe::ChannelSource sources[] = {{.expression = of_class},
                                              {.expression = declared.expression, .dialect = declared.dialect}};
        auto paths = lpe::look_at_paths(lpe::Operation::intersection, sources, words, {.samples = 1});
        if (!paths) return paths.error();
        if (!paths->empty()) return std::optional(MissedPath{paths->samples.front(), {}});
    }
    const std::vector<std::string> omitted = omitted_by(chosen->name, method, scene);
    std::optional<MissedPath> missed;
    if (omitted.empty()) return missed;
    const std::string own = both(of_class, any_path_of(omitted));
    for (const std::string other : {"path", "lighttracer", "bdpt"}) {
        auto found = path_in(paths_without(own, omitted_by(other, {}, scene)), words);
        if (!found) return found.error();
        if (!*found) continue;
        const bool is_shorter = missed && (*found)->events.size() < missed->witness.events.size();
        if (!missed || is_shorter) missed = MissedPath{**found, {}};
        if (missed->witness.text == (*found)->text) missed->methods.push_back(other);
    }
    return missed;
}

bool is_camera_based(const transport::SceneEntity& method, std::optional<std::int64_t> max_depth) {
    auto chosen = transport::choose_integrator(method, max_depth);
    return chosen && !chosen->integrator->traits().raster_splats;
}

}  // namespace raylex::experiments
