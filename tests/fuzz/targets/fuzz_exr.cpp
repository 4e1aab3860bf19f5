// Any bytes as an OpenEXR file, read as layers and as a texture.
#include "display/output/reader/exr_reader.h"
#include "tests/fuzz/fuzz.h"
#include "transport/files/images/image_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const auto image = raylex::display::read_exr(file.path());
    if (image) {
        const auto pixels = static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height);
        for (const auto& layer : image->layers)
            for (const auto& plane : layer.planes)
                fuzz::require(plane.values.size() == pixels, "each plane covers the image");
    } else {
        fuzz::require(!image.error().message.empty(), "a refusal says why");
    }
    static_cast<void>(raylex::transport::read_exr_image(file.path()));
    return 0;
}
