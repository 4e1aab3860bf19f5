#include "experiments/job/rendering/effect_report.h"

#include <algorithm>
#include <array>

#include "geoaovs/geoaovs.h"
#include "lpe/algebra/wording/event_words.h"

namespace raylex::experiments {
namespace {

using transport::EffectChoices;
using transport::EffectFinding;
using transport::EffectFindings;
using transport::EffectInfo;

const EffectFinding& finding_of(const EffectFindings& found, const EffectInfo& info) {
    return found[static_cast<std::size_t>(info.effect)];
}

/// Returns whether the effect is simulated. Forcing on an effect that the scene does not have changes nothing in the
/// image.
bool simulated(const EffectFinding& finding, const std::optional<bool>& forced) {
    return finding.called_for && forced.value_or(true);
}

std::string state_text(const EffectFinding& finding, const std::optional<bool>& forced) {
    if (!forced) return finding.called_for ? "on" : "off";
    return *forced ? "on, forced" : "off, forced";
}

/// A title and a list, wrapped to fit most terminals.
class Listing {
  public:
    explicit Listing(std::string title) : line_(std::move(title)) {}

    void add(const std::string& item) {
        if (count_++ > 0) line_ += ',';
        if (line_.size() + item.size() > 110) {
            lines_.push_back(std::move(line_));
            line_ = " ";
        }
        line_ += " " + item;
    }
    [[nodiscard]] std::size_t count() const { return count_; }
    void append_to(std::vector<std::string>& lines) {
        lines.insert(lines.end(), lines_.begin(), lines_.end());
        lines.push_back(line_);
    }

  private:
    std::vector<std::string> lines_;
    std::string line_;
    std::size_t count_ = 0;
};

std::string column(std::string text, std::size_t width) {
    text.resize(std::max(text.size() + 2, width), ' ');
    return text;
}

/// The kinds of data that AOVs need. For first hits, a kind is one column of data.
struct AovKind {
    const char* name;
    geoaovs::Inputs input;  ///< 0: the kind concerns rays or samples, as `asks` determines
    bool (*asks)(const geoaovs::GeometricAovs& aov) = nullptr;
};

namespace in = geoaovs::inputs;
constexpr std::array aov_kinds{
    AovKind{"positions", in::position},
    AovKind{"shading normals", in::shading_normal},
    AovKind{"geometric normals", in::geometric_normal},
    AovKind{"normals before bumps", in::plain_normal},
    AovKind{"directions of view", in::view},
    AovKind{"texture coordinates", in::texture},
    AovKind{"parameters of primitives", in::parameters},
    AovKind{"tangents along u", in::dpdu},
    AovKind{"tangents along v", in::dpdv},
    AovKind{"positions in objects", in::object_position},
    AovKind{"curvature", in::curvature},
    AovKind{"refractive indices", in::outside_ior},
    AovKind{"numbers of objects", in::ids},
    AovKind{"distances to edges", in::edges},
    AovKind{"albedo", in::albedo},
    AovKind{"depths of rays", 0, [](const geoaovs::GeometricAovs& aov) { return aov.wants_rays(); }},
    AovKind{"counts of samples", 0,
            [](const geoaovs::GeometricAovs& aov) { return aov.wants_samples() && !aov.wants_time(); }},
    AovKind{"times of samples", 0, [](const geoaovs::GeometricAovs& aov) { return aov.wants_time(); }},
};

/// Returns for each kind the channels that need it.
std::array<std::vector<std::string>, aov_kinds.size()> askers(std::span<const display::ChannelDefinition> channels) {
    std::array<std::vector<std::string>, aov_kinds.size()> found;
    for (const display::ChannelDefinition& channel : channels) {
        const geoaovs::GeometricAovs aov({&channel, 1});
        for (std::size_t i = 0; i < aov_kinds.size(); ++i) {
            const AovKind& kind = aov_kinds[i];
            if (kind.asks != nullptr ? kind.asks(aov) : (aov.inputs() & kind.input) != 0)
                found[i].push_back(channel.name);
        }
    }
    return found;
}

/// Returns the consequence of a forced effect that differs from the scene's needs.
std::string consequence(const EffectInfo& info, const EffectFinding& finding, const std::optional<bool>& forced) {
    if (!forced || *forced == finding.called_for) return {};
    if (!*forced) return std::string("; instead: ") + info.without;
    const std::string code = info.general_code;
    return "; without effect: " + (code.empty() ? std::string("it has no code in the way of others") : code);
}

}  // namespace

std::vector<std::string> effect_summary(const EffectFindings& found, const EffectChoices& choices) {
    Listing on("effects:"), off("left out, the scene has none:"), forced("forced:");
    for (const EffectInfo& info : transport::effect_catalogue()) {
        const EffectFinding& finding = finding_of(found, info);
        const std::optional<bool>& choice = choices[info.effect];
        const std::string name = info.name;
        if (simulated(finding, choice)) on.add(name + " (" + finding.why + ")");
        else if (!finding.called_for) off.add(name);
        if (!choice) continue;
        const char* const against = *choice == finding.called_for ? ""
                                    : *choice                     ? " (the scene has none: the image is the same)"
                                                                  : " (the scene has it)";
        forced.add(name + (*choice ? " on" : " off") + against);
    }
    if (on.count() == 0) on.add("none");
    std::vector<std::string> lines;
    on.append_to(lines);
    if (off.count() > 0) off.append_to(lines);
    if (forced.count() > 0) forced.append_to(lines);
    return lines;
}

std::vector<std::string> effect_table(const EffectFindings& found, const EffectChoices& choices) {
    std::vector<std::string> lines{column("effect", 21) + column("simulated", 13) + "why"};
    for (const EffectInfo& info : transport::effect_catalogue()) {
        const EffectFinding& finding = finding_of(found, info);
        const std::optional<bool>& choice = choices[info.effect];
        lines.push_back(column(info.name, 21) + column(state_text(finding, choice), 13) + finding.why +
                        consequence(info, finding, choice));
    }
    for (const transport::AbsentEffect& each : transport::effects_not_simulated())
        lines.push_back(column(each.name, 21) + column("never", 13) + each.consequence);
    return lines;
}

std::vector<std::string> aov_summary(std::span<const display::ChannelDefinition> channels) {
    const auto found = askers(channels);
    Listing on("AOVs need:");
    for (std::size_t i = 0; i < found.size(); ++i)
        if (!found[i].empty()) on.add(std::string(aov_kinds[i].name) + " (" + lpe::joined_by(found[i], ", ") + ")");
    std::vector<std::string> lines;
    if (on.count() > 0) on.append_to(lines);
    return lines;
}

std::vector<std::string> aov_table(std::span<const display::ChannelDefinition> channels) {
    const auto found = askers(channels);
    std::vector<std::string> lines{column("kind of AOV", 26) + column("computed", 13) + "why"};
    for (std::size_t i = 0; i < found.size(); ++i) {
        const bool requested = !found[i].empty();
        lines.push_back(column(aov_kinds[i].name, 26) + column(requested ? "on" : "off", 13) +
                        (requested ? "for " + lpe::joined_by(found[i], ", ") : "not requested"));
    }
    return lines;
}

Json aovs_json(std::span<const display::ChannelDefinition> channels) {
    const auto found = askers(channels);
    Json json = Json::object();
    for (std::size_t i = 0; i < found.size(); ++i)
        if (!found[i].empty()) json[aov_kinds[i].name] = found[i];
    return json;
}

Json effects_json(const EffectFindings& found, const EffectChoices& choices) {
    Json json = Json::object();
    for (const EffectInfo& info : transport::effect_catalogue()) {
        const EffectFinding& finding = finding_of(found, info);
        const std::optional<bool>& choice = choices[info.effect];
        json[info.name] = {{"simulated", simulated(finding, choice)},
                           {"called_for", finding.called_for},
                           {"forced", choice ? Json(*choice) : Json(nullptr)},
                           {"why", finding.why}};
    }
    return json;
}

}  // namespace raylex::experiments
