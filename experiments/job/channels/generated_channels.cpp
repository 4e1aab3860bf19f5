#include "experiments/job/channels/generated_channels.h"

#include <algorithm>
#include <cstdint>
#include <map>

#include "lpe/language/glob.h"
#include "lpe/shipped.h"

namespace raylex::experiments {
namespace {

std::string layer_name_for(const std::string& group) {
    std::string name = "light_";
    for (const char c : group) {
        const bool fits =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
        name += fits ? c : '_';
    }
    return name;
}

bool emission_carries(const transport::SceneAlphabet& alphabet, const std::string& group) {
    return std::any_of(alphabet.terminals.begin(), alphabet.terminals.end(), [&](const lpe::Event& event) {
        return event.type == lpe::EventType::emission &&
               (event.labels.empty() ? group.empty() : event.labels.front() == group);
    });
}

}  // namespace

std::vector<ExpressionRequest> shipped_channels() {
    std::vector<ExpressionRequest> requests;
    for (const lpe::NamedExpression& each : lpe::shipped_partition())
        requests.push_back({std::string(each.name),
                            std::string(each.expression),
                            lpe::Dialect::renderman,
                            {"the shipped partition", 0, 0}});
    return requests;
}

std::vector<ExpressionRequest> light_group_channels(const transport::SceneAlphabet& alphabet) {
    std::vector<ExpressionRequest> requests;
    std::map<std::string, int> taken{{"light_default", 1}};
    const SourceLocation where{"the light groups", 0, 0};
    for (const std::string& group : alphabet.light_groups) {
        if (group.empty()) continue;
        std::string name = layer_name_for(group);
        if (const int count = ++taken[name]; count > 1) name += "_" + std::to_string(count);
        const std::string label = lpe::quoted_label(group);
        const std::string terminal =
            emission_carries(alphabet, group) ? "[<L." + label + "><O." + label + ">]" : "<L." + label + ">";
        requests.push_back({name, "C.*" + terminal, lpe::Dialect::renderman, where});
    }
    requests.push_back({"light_default", emission_carries(alphabet, "") ? "C.*[<L.''><O.''>]" : "C.*<L.''>",
                        lpe::Dialect::renderman, where});
    return requests;
}

std::vector<TechniqueLayer> technique_layers(std::optional<int> max_depth) {
    constexpr std::uint32_t most_vertices = 8;
    // Paths through subsurface bodies can scatter more often than "maxdepth", so the depth is then unknown.
    const auto depth = max_depth ? static_cast<std::uint32_t>(std::max(*max_depth, 1)) : most_vertices;
    const std::uint32_t vertices = std::min(depth + 2, most_vertices);
    std::vector<TechniqueLayer> layers;
    for (std::uint32_t n = 2; n <= vertices; ++n)
        for (std::uint32_t s = 0; s < (n == 2 ? 1 : n); ++s) {
            const std::string technique = "s" + std::to_string(s) + "t" + std::to_string(n - s);
            layers.push_back({technique, technique});
            layers.push_back({technique + "_unweighted", technique + ";unweighted", false});
        }
    const std::string beyond = "beyond" + std::to_string(vertices);
    if (depth + 2 > vertices) layers.push_back({beyond, beyond});
    return layers;
}

}  // namespace raylex::experiments
