// A trained guide as bytes, for checkpoints.
#include "display/buffer/record_bytes.h"
#include "transport/render/pilots/guide_pilot.h"

namespace raylex::transport {
namespace {

template <class Visit, class Summary>
void visit_summary(const Visit& visit, Summary& summary) {
    visit(summary.samples), visit(summary.paths), visit(summary.regions), visit(summary.bytes);
    visit(summary.guided), visit(summary.gain), visit(summary.used), visit(summary.read), visit(summary.cut);
    visit(summary.seconds), visit(summary.cpu_seconds);
}

}  // namespace

std::string TrainedGuide::record() const {
    std::string bytes;
    display::RecordWriter writer(bytes);
    visit_summary([&](const auto& each) { writer.number(each); }, summary);
    if (guide != nullptr) guide->tree().append_record(bytes);
    return bytes;
}

std::optional<TrainedGuide> TrainedGuide::from_record(std::string_view bytes) {
    TrainedGuide trained;
    display::RecordReader reader(bytes);
    visit_summary([&](auto& each) { each = reader.number<std::remove_reference_t<decltype(each)>>(); },
                  trained.summary);
    if (!trained.summary.used) return reader.at_end() ? std::optional(std::move(trained)) : std::nullopt;
    auto tree = reader.ok() ? GuideTree::from_record(reader.rest()) : std::nullopt;
    if (!tree) return std::nullopt;
    trained.guide = std::make_unique<Guide>(*std::move(tree));
    return trained;
}

}  // namespace raylex::transport
