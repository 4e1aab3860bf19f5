// Which effects a render simulates, and why, as lines for people and as JSON.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "experiments/job/text/json.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// NAME=on or NAME=off, as --effect takes it. Errors at `where`: no such effect, neither on nor off.
Status add_effect_choice(const std::string& text, const SourceLocation& where, transport::EffectChoices& choices);

/// What is simulated and what is not, in a few lines; the last say what is forced.
std::vector<std::string> effect_summary(const transport::EffectFindings& found,
                                        const transport::EffectChoices& choices);
/// A line for every effect, with why; then what raylex does not simulate.
std::vector<std::string> effect_table(const transport::EffectFindings& found, const transport::EffectChoices& choices);

/// {NAME: {"simulated", "called_for", "forced" (null, true, false), "why"}}
Json effects_json(const transport::EffectFindings& found, const transport::EffectChoices& choices);

/// Which kinds of geometric AOV are asked for, of first hits, camera rays and samples, and by whom, in a line or two;
/// what nobody asks for is not computed. Empty where there is no such AOV.
std::vector<std::string> aov_summary(std::span<const display::ChannelDefinition> channels);
/// A line for every kind.
std::vector<std::string> aov_table(std::span<const display::ChannelDefinition> channels);
/// {KIND: [NAME...]}, of what is asked for.
Json aovs_json(std::span<const display::ChannelDefinition> channels);

}  // namespace raylex::experiments
