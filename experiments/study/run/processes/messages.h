// Values of an experiment as messages between the processes that run it.
#pragma once

#include <string>

#include "experiments/job/text/json.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

using Message = Json;

/// Bytes that hold every number and text as it is, be it UTF-8 or not.
std::string packed(const Message& message);
/// What packed() made. Throws where it is something else.
Message unpacked(const std::string& bytes);

Message error_message(const Error& error);
Error error_of(const Message& message);
Message cell_message(const Cell& cell);
Cell cell_of_message(const Message& message);
Message scene_message(const SceneInfo& scene);
SceneInfo scene_of_message(const Message& message);
Message partitions_message(const std::vector<PartitionInfo>& partitions);
std::vector<PartitionInfo> partitions_of_message(const Message& message);

}  // namespace raylex::experiments
