// Lists the effects that a render simulates, with reasons, as text for people and as JSON.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "experiments/job/text/json.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// Returns a few lines about simulated and omitted effects; the last lines list forced effects.
std::vector<std::string> effect_summary(const transport::EffectFindings& found,
                                        const transport::EffectChoices& choices);
/// Returns a line for every effect with the reason, then the effects that raylex does not support.
std::vector<std::string> effect_table(const transport::EffectFindings& found, const transport::EffectChoices& choices);

/// {NAME: {"simulated", "called_for", "forced" (null, true, false), "why"}}
Json effects_json(const transport::EffectFindings& found, const transport::EffectChoices& choices);

/// Returns one or two lines about the requested kinds of geometric AOVs (of first hits, camera rays and samples) and
/// the channels that need them. Other kinds are not computed. Empty if there is no such AOV.
std::vector<std::string> aov_summary(std::span<const display::ChannelDefinition> channels);
/// Returns a line for every kind of AOV.
std::vector<std::string> aov_table(std::span<const display::ChannelDefinition> channels);
/// Returns {KIND: [NAME...]} of the requested kinds.
Json aovs_json(std::span<const display::ChannelDefinition> channels);

}  // namespace raylex::experiments
