// Finds probably misspelt labels without a scene: labels that are not in the list of known ones, or that differ by one
// typing error from a name that more channels use.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct KnownLabels {
    std::optional<std::vector<std::string>> groups;  ///< of lights; none: unknown
    std::optional<std::vector<std::string>> labels;  ///< of objects and media
};

/// Returns one sentence for each suspicious label, with the channels that use it. Lobe names are not checked. Errors: a
/// channel does not parse.
Result<std::vector<std::string>> label_warnings(std::span<const lpe::ChannelSource> channels, const KnownLabels& known);

}  // namespace raylex::experiments
