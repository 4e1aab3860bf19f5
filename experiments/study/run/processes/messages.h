// Converts values of an experiment to messages between its processes.
#pragma once

#include <string>

#include "experiments/job/text/json.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

using Message = Json;

/// Returns a message as bytes. Numbers are exact, and texts can be any bytes.
std::string packed(const Message& message);
/// Parses the bytes of packed(). Throws for any other bytes.
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
