// Labels that are likely slips of the pen, found without a scene: not among those that are known to exist, or once
// beside a name that differs by one slip and stands in many channels.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct KnownLabels {
    std::optional<std::vector<std::string>> groups;  ///< of lights; none: not known
    std::optional<std::vector<std::string>> labels;  ///< of objects and media
};

/// One sentence for each doubtful label, the channels that name it with it. Lobe names are not doubted. Errors: a
/// channel that does not parse.
Result<std::vector<std::string>> label_doubts(std::span<const lpe::ChannelSource> channels, const KnownLabels& known);

}  // namespace raylex::experiments
