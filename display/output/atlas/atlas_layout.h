// Names of the parts and channels in the file of an atlas. Private to the atlas's files.
#pragma once

#include <string>
#include <vector>

#include "display/buffer/sinks/path_atlas.h"

namespace raylex::display {

struct AtlasLayout {
    static constexpr const char* parts[] = {"rgba", "words", "parts"};
    static constexpr const char* word = "word";
    static constexpr const char* colors[] = {"R", "G", "B"};
    static constexpr const char* rests[] = {"Rrest", "Grest", "Brest"};  ///< if light can be negative
    /// The value of `eighth` is the number, from 1, of the eighth of the samples that found all of a word's luminance,
    /// or one of the special values below.
    static constexpr const char* eighth = "eighth";
    static constexpr std::uint32_t no_luminance = 0, several_eighths = PathAtlas::parts + 1;
    static std::string part(std::size_t k) { return "p" + std::to_string(k); }
    static std::string count(std::size_t k) { return "n" + std::to_string(k); }
    /// The planes in the order of AtlasRow: rgba, then counts.
    static std::vector<std::string> flat_planes() {
        std::vector<std::string> planes{"R", "G", "B", "A"};
        for (std::size_t k = 0; k < PathAtlas::parts; ++k) planes.push_back(count(k));
        return planes;
    }
};

}  // namespace raylex::display
