// Converts values of an experiment to messages between its processes.
#pragma once

#include <string>

#include "experiments/study/results_json.h"
#include "lpe/result.h"

namespace raylex::experiments {

using Message = Json;

/// Returns a message as bytes. Numbers are exact, and texts can be any bytes.
std::string packed(const Message& message);
/// Parses the bytes of packed(). Throws for any other bytes.
Message unpacked(const std::string& bytes);

Message run_message(const StudyRun& run);
StudyRun run_of_message(const Message& message);
RAYLEX_JSON_FIELDS(Error, message, file, line, column, excerpt, hint)

}  // namespace raylex::experiments
