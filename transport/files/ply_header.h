// The header of a PLY file: elements and their properties.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/result.h"

namespace raylex::transport::ply {

enum class Format : std::uint8_t { ascii, little_endian, big_endian };
enum class Scalar : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

[[nodiscard]] std::size_t size_of(Scalar type);

struct Property {
    std::string name;
    Scalar type = Scalar::float32;
    bool is_list = false;
    Scalar count_type = Scalar::uint8;  ///< of a list's length
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;

    /// The minimum number of bytes of one row in a binary file: lists count as empty.
    [[nodiscard]] std::size_t smallest_row() const;
};

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
    std::size_t data_begin = 0;  ///< byte offset after the end_header line
    int lines = 0;               ///< lines of the header

    [[nodiscard]] const Element* find(std::string_view name) const;
};

Result<Header> parse_header(std::string_view content, const std::string& path);

}  // namespace raylex::transport::ply
