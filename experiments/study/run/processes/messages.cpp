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

Message cell_message(const Cell& cell) {
    return {{"text", cell_text(cell)}, {"directory", cell.directory}};
}

Cell cell_of_message(const Message& message) {
    auto cell = cell_of_text(message.at("text"), "a message");
    if (!cell) throw std::runtime_error(cell.error().to_string());
    cell->directory = message.at("directory");
    return *std::move(cell);
}

}  // namespace raylex::experiments
