// Reads and writes .npy, version 1.0 and 2.0, NumPy's format for one array.
// Source: numpy.lib.format, https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "display/services/parameters.h"
#include "experiments/study/results.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written in memory order");

constexpr std::string_view magic = "\x93NUMPY";

Error npy_error(const std::string& path, const std::string& found) {
    return error_at({path, 0, 0}, "this is not a .npy file that raylex can read: " + found);
}

/// Returns the header dictionary, padded so that the data begin at a multiple of 64 bytes.
std::string npy_header(const char* type, const std::vector<std::size_t>& shape) {
    std::string sizes;
    for (const std::size_t each : shape) sizes += (sizes.empty() ? "" : ", ") + std::to_string(each);
    std::string dictionary =
        "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" + sizes + "), }";
    const std::size_t before = magic.size() + 4;  // version and length
    dictionary.append(63 - (before + dictionary.size()) % 64, ' ');
    dictionary += '\n';
    std::string header(magic);
    header += {'\x01', '\x00', static_cast<char>(dictionary.size() & 0xFF), static_cast<char>(dictionary.size() >> 8)};
    return header + dictionary;
}

Status write_array(const std::string& path, const std::string& header, const void* values, std::size_t bytes,
                   display::FileSync sync) {
    auto file = display::AtomicFile::create(path, sync);
    if (!file) return file.error();
    const char* from = static_cast<const char*>(values);
    // An array of zeros, as for a channel without light, becomes a hole in the file, which takes no space.
    std::size_t skipped = 0;
    if (bytes > 1 && *from == 0 && std::memcmp(from, from + 1, bytes - 1) == 0) skipped = bytes - 1;
    if (!file->write(header.data(), header.size()) || !file->seek(header.size() + skipped) ||
        !file->write(from + skipped, bytes - skipped))
        return file->failure();
    return file->commit();
}

/// Returns the text after 'KEY': in the dictionary.
std::string_view entry(std::string_view dictionary, std::string_view key) {
    const std::size_t at = dictionary.find("'" + std::string(key) + "':");
    if (at == std::string_view::npos) return {};
    std::string_view rest = dictionary.substr(at + key.size() + 3);
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    return rest;
}

/// Parses "(480, 640, 3), ..."; returns nothing if it is not a tuple of sizes.
std::optional<std::vector<std::size_t>> shape_of(std::string_view text) {
    if (text.empty() || text.front() != '(') return std::nullopt;
    std::vector<std::size_t> shape;
    std::size_t number = 0;
    bool digits = false;
    for (const char c : text.substr(1)) {
        if (c >= '0' && c <= '9') {
            if (number > (std::size_t{1} << 40)) return std::nullopt;
            number = 10 * number + static_cast<std::size_t>(c - '0');
            digits = true;
        } else if (c == ',' || c == ')') {
            if (digits) shape.push_back(number);
            number = 0;
            digits = false;
            if (c == ')') return shape;
        } else if (c != ' ') {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

template <class Number>
void convert(const char* bytes, std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        Number number;
        std::memcpy(&number, bytes + i * sizeof number, sizeof number);
        values[i] = static_cast<double>(number);
    }
}

struct NumberType {
    const char* name;  ///< without the byte-order mark
    std::size_t size;
    void (*convert)(const char*, std::vector<double>&);
};
constexpr NumberType number_types[] = {
    {"f8", 8, convert<double>},        {"f4", 4, convert<float>},         {"u8", 8, convert<std::uint64_t>},
    {"i8", 8, convert<std::int64_t>},  {"u4", 4, convert<std::uint32_t>}, {"i4", 4, convert<std::int32_t>},
    {"u2", 2, convert<std::uint16_t>}, {"i2", 2, convert<std::int16_t>},  {"u1", 1, convert<std::uint8_t>},
    {"i1", 1, convert<std::int8_t>},   {"b1", 1, convert<std::uint8_t>},
};

const NumberType* number_type(std::string_view description) {
    for (const NumberType& each : number_types)
        for (const char order : {'<', '|', '='})
            if (description.starts_with("'" + std::string(1, order) + each.name + "'")) return &each;
    return nullptr;
}

}  // namespace

Result<PixelArray> read_npy(const std::string& path) {
    const Result<std::string> content = read_record(path, "a .npy array", Budget::file_bytes);
    if (!content) return content.error();
    const std::string& bytes = *content;
    const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at])); };
    if (bytes.size() < magic.size() + 6 || !bytes.starts_with(magic))
        return npy_error(path, "it has the wrong beginning");
    const std::size_t version = byte(6);
    if (version < 1 || version > 3) return npy_error(path, "version " + std::to_string(version) + "; expected 1 to 3");
    std::size_t start = 10, length = byte(8) | byte(9) << 8;
    if (version > 1) {
        start = 12;
        length |= byte(10) << 16 | byte(11) << 24;
    }
    if (start + length > bytes.size()) return npy_error(path, "it ends inside its header");
    const std::string_view dictionary(bytes.data() + start, length);
    const NumberType* type = number_type(entry(dictionary, "descr"));
    if (type == nullptr)
        return npy_error(path, "its numbers are neither little-endian integers nor float32 nor float64");
    if (!entry(dictionary, "fortran_order").starts_with("False"))
        return npy_error(path, "it is in Fortran order; expected C order");
    const auto shape = shape_of(entry(dictionary, "shape"));
    if (!shape || shape->size() < 2 || shape->size() > 3)
        return npy_error(path, "it does not have two or three dimensions: height, width, components");
    PixelArray array{(*shape)[0], (*shape)[1], shape->size() == 3 ? (*shape)[2] : 1, {}};
    std::size_t count = type->size;
    for (const std::size_t each : {array.height, array.width, array.components}) {
        if (each != 0 && count > std::numeric_limits<std::size_t>::max() / each)
            return npy_error(path, "its shape is out of range");
        count *= each;
    }
    if (bytes.size() - start - length != count)
        return npy_error(path, std::to_string(bytes.size() - start - length) + " bytes of numbers; its header says " +
                                   std::to_string(count));
    array.values.resize(count / type->size);
    type->convert(bytes.data() + start + length, array.values);
    return array;
}

Status write_npy(const std::string& path, const PixelArray& array, display::FileSync sync) {
    return write_array(path, npy_header("<f8", {array.height, array.width, array.components}), array.values.data(),
                       array.values.size() * sizeof(double), sync);
}

Status write_npy_counts(const std::string& path, std::size_t height, std::size_t width,
                        const std::vector<std::uint64_t>& counts, display::FileSync sync) {
    return write_array(path, npy_header("<u8", {height, width}), counts.data(), counts.size() * sizeof(std::uint64_t),
                       sync);
}

namespace {

Result<PixelArray> read_plane(const std::string& directory, const std::string& name, const char* hint) {
    auto array = read_npy(directory + "/" + name);
    if (array) return array;
    Error error = array.error();
    if (error.hint.empty()) error.hint = hint;
    return error;
}

}  // namespace

Result<PixelArray> read_mean(const std::string& directory, const std::string& channel) {
    return read_plane(directory, channel + ".mean.npy", "");
}

Result<PixelArray> read_m2(const std::string& directory, const std::string& channel) {
    return read_plane(directory, channel + ".m2.npy",
                      "methods that splat, external renderers and imported images have no statistics of pixels");
}

Result<PixelArray> read_samples(const std::string& directory) {
    return read_plane(directory, "samples.npy", "");
}

}  // namespace raylex::experiments
