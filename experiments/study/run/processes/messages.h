// Converts values of an experiment to messages between its processes.
#pragma once

#include <string>

#include "experiments/job/text/json.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

using Message = Json;

/// Declares to_json() and from_json() for these fields of a struct, as NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE does for
/// nlohmann::json. Use it in the struct's namespace.
#define RAYLEX_MESSAGE_FIELDS(Type, ...)                                           \
    inline void to_json(Message& nlohmann_json_j, const Type& nlohmann_json_t) {   \
        NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, __VA_ARGS__))   \
    }                                                                              \
    inline void from_json(const Message& nlohmann_json_j, Type& nlohmann_json_t) { \
        NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_FROM, __VA_ARGS__)) \
    }

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
