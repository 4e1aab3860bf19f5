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

Message error_message(const Error& error) {
    return {{"message", error.message}, {"file", error.file},       {"line", error.line},
            {"column", error.column},   {"excerpt", error.excerpt}, {"hint", error.hint}};
}

Error error_of(const Message& message) {
    Error error;
    error.message = message.at("message");
    error.file = message.at("file");
    error.line = message.at("line");
    error.column = message.at("column");
    error.excerpt = message.at("excerpt");
    error.hint = message.at("hint");
    return error;
}

Message cell_message(const Cell& cell) {
    return {{"text", cell_text(cell)}, {"directory", cell.directory}};
}

Cell cell_of_message(const Message& message) {
    auto cell = cell_of_text(message.at("text"), "a message");
    if (!cell) throw std::runtime_error(cell.error().to_string());
    cell->directory = message.at("directory");
    return *std::move(cell);
}

Message scene_message(const SceneInfo& scene) {
    Message channels = Message::array();
    for (const ChannelInfo& each : scene.channels)
        channels.push_back({each.name, each.expression, each.dialect, each.beauty});
    return {{"name", scene.name},
            {"file", scene.file},
            {"hash", scene.hash},
            {"width", scene.width},
            {"height", scene.height},
            {"channels", channels},
            {"reference", scene.reference},
            {"reference_relative_error", scene.reference_relative_error},
            {"reference_method", scene.reference_method},
            {"reference_samples", scene.reference_samples},
            {"reference_failure", scene.reference_failure}};
}

SceneInfo scene_of_message(const Message& message) {
    SceneInfo scene;
    scene.name = message.at("name");
    scene.file = message.at("file");
    scene.hash = message.at("hash");
    scene.width = message.at("width");
    scene.height = message.at("height");
    for (const Message& each : message.at("channels"))
        scene.channels.push_back({each.at(0), each.at(1), each.at(2), each.at(3)});
    scene.reference = message.at("reference");
    scene.reference_relative_error = message.at("reference_relative_error");
    scene.reference_method = message.at("reference_method");
    scene.reference_samples = message.at("reference_samples");
    scene.reference_failure = message.at("reference_failure");
    return scene;
}

Message partitions_message(const std::vector<PartitionInfo>& partitions) {
    Message list = Message::array();
    for (const PartitionInfo& each : partitions) list.push_back({each.name, each.of, each.channels});
    return list;
}

std::vector<PartitionInfo> partitions_of_message(const Message& message) {
    std::vector<PartitionInfo> partitions;
    for (const Message& each : message)
        partitions.push_back({each.at(0), each.at(1), each.at(2).get<std::vector<std::string>>()});
    return partitions;
}

}  // namespace raylex::experiments
