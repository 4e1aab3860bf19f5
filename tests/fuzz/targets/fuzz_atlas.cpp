// Any bytes as a path atlas, each of its rows read with the shares of eighths and without.
#include <algorithm>

#include "display/output/atlas/atlas_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const auto atlas = raylex::display::AtlasFile::open(file.path());
    if (!atlas) {
        fuzz::require(!atlas.error().message.empty(), "a refusal says why");
        return 0;
    }
    const std::size_t words = (*atlas)->table().words.size();
    raylex::display::AtlasRow row;
    // A header of a few bytes can claim a million rows, each of which ends in the same message.
    const int height = std::min((*atlas)->height(), 64);
    for (const bool parts : {true, false}) {
        (*atlas)->read_parts(parts);
        for (int y = 0; y < height; ++y) {
            if (!(*atlas)->row(y, row)) continue;
            fuzz::require(row.begin.size() == static_cast<std::size_t>((*atlas)->width()) + 1, "every pixel has words");
            fuzz::require(row.begin.back() == row.samples.size(), "all words are of pixels");
            for (const auto& sample : row.samples) fuzz::require(sample.word < words, "a word is one of the table");
        }
    }
    return 0;
}
