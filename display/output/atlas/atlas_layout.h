// Names of the parts and channels of an atlas's file. Private to the atlas's files.
#pragma once

#include <string>
#include <vector>

#include "display/buffer/sinks/path_atlas.h"

namespace raylex::display {

struct AtlasLayout {
    static constexpr const char* parts[] = {"rgba", "words", "parts"};
    static constexpr const char* word = "word";
    static constexpr const char* colors[] = {"R", "G", "B"};
    static constexpr const char* rests[] = {"Rrest", "Grest", "Brest"};  ///< where light may be negative
    /// What `eighth` says beside which eighth of the samples, counted from 1, brought all of a word's luminance.
    static constexpr const char* eighth = "eighth";
    static constexpr std::uint32_t no_luminance = 0, several_eighths = PathAtlas::parts + 1;
    static std::string part(std::size_t k) { return "p" + std::to_string(k); }
    static std::string count(std::size_t k) { return "n" + std::to_string(k); }
    /// In the order of AtlasRow: rgba, then counts.
    static std::vector<std::string> flat_planes() {
        std::vector<std::string> planes{"R", "G", "B", "A"};
        for (std::size_t k = 0; k < PathAtlas::parts; ++k) planes.push_back(count(k));
        return planes;
    }
};

}  // namespace raylex::display
