// Any bytes as a channel file: RIB, USD ASCII or rendermn.ini by the first byte. Refused with line and column, or read;
// what is read can be written, and what is written is read again with the same channels.
#include "lpe/channels/channel_file.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

namespace {

/// Blanks around an expression mean nothing and are not kept.
std::string_view trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    return begin == std::string_view::npos ? std::string_view{}
                                           : text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    fuzz::Bytes bytes(data, size);
    const auto format = static_cast<ChannelFormat>(bytes.below(3));
    const auto file = parse_channel_file(bytes.rest(), "fuzzed", format);
    if (!file) {
        fuzz::require(file.error().line > 0 && file.error().column > 0, "a refusal names line and column");
        return 0;
    }
    std::vector<std::string> warnings;
    const auto text = write_channel_file(*file, format, warnings, Reader::raylex);
    if (!text) return 0;  // names or expressions that the format cannot hold
    const auto again = parse_channel_file(*text, "written", format);
    fuzz::require(again.ok(), "what is written can be read:\n" + *text);
    fuzz::require(again->channels.size() == file->channels.size(), "no channel is lost:\n" + *text);
    if (format == ChannelFormat::rib)
        fuzz::require(again->other_channels.size() == file->other_channels.size(),
                      "no other channel is lost:\n" + *text);
    for (std::size_t k = 0; k < again->channels.size(); ++k) {
        // Formats that hold one line leave comments and line ends out, which changes the text but not the language.
        if (file->channels[k].source.expression.find_first_of("#\n\r") != std::string::npos) continue;
        fuzz::require(trimmed(again->channels[k].source.expression) == trimmed(file->channels[k].source.expression),
                      "expressions come back as they were:\n" + *text);
    }
    return 0;
}
