// Any bytes as a path's text: refused with a column, or read, written and read again as the same path.
#include "lpe/match.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    const std::string text = fuzz::Bytes(data, size).rest();
    const auto events = parse_events(text);
    if (!events) {
        fuzz::require(events.error().column > 0, "a refusal names its column");
        return 0;
    }
    const std::string written = to_text(*events);
    const auto again = parse_events(written);
    fuzz::require(again.ok(), "what is written can be read: " + written);
    fuzz::require(to_text(*again) == written, "writing is stable: " + written);
    fuzz::require(again->size() == events->size(), "no event is lost: " + written);
    fuzz::require(events->empty() || !to_sentence(*events).empty(), "a path can be said");
    return 0;
}
