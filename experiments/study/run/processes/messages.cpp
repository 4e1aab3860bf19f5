#include "experiments/study/run/processes/messages.h"

#include "experiments/study/results_file.h"

namespace raylex::experiments {

std::string packed(const Message& message) {
    std::string bytes;
    Message::to_msgpack(message, bytes);
    return bytes;
}

Message unpacked(const std::string& bytes) {
    return Message::from_msgpack(bytes);
}

Message run_message(const StudyRun& run) {
    return {{"text", run_text(run)}, {"directory", run.directory}};
}

StudyRun run_of_message(const Message& message) {
    auto run = run_of_text(message.at("text"), "a message");
    if (!run) throw std::runtime_error(run.error().to_string());
    run->directory = message.at("directory");
    return *std::move(run);
}

}  // namespace raylex::experiments
