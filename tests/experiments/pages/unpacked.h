// The bytes that a page packed (experiments/report/pixel_data.h).
#pragma once

#include <zlib.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace raylex::test {

/// Returns the `size` bytes of a text that pack_bytes() made.
inline std::vector<unsigned char> unpacked(const std::string& text, std::size_t size) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<unsigned char> packed, bytes(size);
    unsigned bits = 0, count = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6U | static_cast<unsigned>(letters.find(c));
        count += 6;
        if (count < 8) continue;
        count -= 8;
        packed.push_back(static_cast<unsigned char>(bits >> count & 255U));
    }
    uLongf length = size;
    REQUIRE(uncompress(bytes.data(), &length, packed.data(), packed.size()) == Z_OK);
    REQUIRE(length == size);
    return bytes;
}

}  // namespace raylex::test
