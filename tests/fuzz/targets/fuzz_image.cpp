// Any bytes as an image file: what is read has as many samples as its size says.
#include "tests/fuzz/fuzz.h"
#include "transport/files/images/image_readers.h"

using namespace raylex::transport;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const std::string content = fuzz::Bytes(data, size).rest();
    const auto image = content.starts_with("PF") || content.starts_with("Pf") ? read_pfm(content, "fuzzed")
                       : content.starts_with("\x89PNG")                       ? read_png(content, "fuzzed", {})
                       : content.starts_with("\xff\xd8")                      ? read_jpeg(content, "fuzzed", {})
                       : content.starts_with("qoif")                          ? read_qoi(content, "fuzzed", {})
                                                                              : read_with_stb(content, "fuzzed", {});
    if (!image) {
        fuzz::require(!image.error().message.empty(), "a refusal says why");
        return 0;
    }
    const auto samples = static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height) *
                         static_cast<std::size_t>(image->channels);
    fuzz::require(image->pixels.size() == samples, "as many samples as the size says");
    return 0;
}
