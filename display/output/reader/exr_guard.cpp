#include "display/output/reader/exr_guard.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include <ImfThreading.h>

#include "lpe/input/read_input.h"

namespace raylex::display {

namespace {

constexpr const char* wanted = "an OpenEXR file";

struct Box {
    std::int32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;

    /// A floating-point number, because corners can be 2^32 apart.
    [[nodiscard]] double pixels() const {
        return (static_cast<double>(max_x) - min_x + 1) * (static_cast<double>(max_y) - min_y + 1);
    }
    [[nodiscard]] bool empty() const { return max_x < min_x || max_y < min_y; }
    bool operator==(const Box&) const = default;
};

/// The sizes that the header of one part declares.
struct PartHeader {
    Box data, display;
    bool deep = false;              ///< by its type, which deep parts must have; the library ignores the version field
    unsigned char compression = 3;  ///< numbered as in the file; 0 is none
    double pixel_bytes = 0, channels = 0;  ///< bytes of a stored pixel
};

Error failure(const std::string& path, const std::string& message) {
    return {message, path, 0, 0, {}, {}};
}

/// Attribute types with a fixed size. Whatever size the header claims, the library reads this many bytes and treats the
/// following bytes as the next attribute. Source: "OpenEXR File Layout", openexr.com, predefined attribute types.
struct FixedSize {
    std::string_view type;
    std::uint32_t bytes;
};
constexpr FixedSize fixed_sizes[] = {{"box2i", 16},
                                     {"box2f", 16},
                                     {"chromaticities", 32},
                                     {"compression", 1},
                                     {"deepImageState", 1},
                                     {"double", 8},
                                     {"envmap", 1},
                                     {"float", 4},
                                     {"int", 4},
                                     {"keycode", 28},
                                     {"lineOrder", 1},
                                     {"m33f", 36},
                                     {"m33d", 72},
                                     {"m44f", 64},
                                     {"m44d", 128},
                                     {"rational", 8},
                                     {"tiledesc", 9},
                                     {"timecode", 8},
                                     {"v2i", 8},
                                     {"v2f", 8},
                                     {"v2d", 16},
                                     {"v3i", 12},
                                     {"v3f", 12},
                                     {"v3d", 24}};

class HeaderReader {
  public:
    HeaderReader(const std::string& path, std::uint64_t size)
        : path_(path), stream_(path, std::ios::binary), left_(size) {}

    Result<std::vector<PartHeader>> parts() {
        char start[8] = {};
        if (!take(start, 8)) return failure(path_, "the file is truncated or damaged: it ends in its header");
        const bool many = (static_cast<unsigned char>(start[5]) & 0x10U) != 0;  // bit 12 of the version field
        std::vector<PartHeader> found;
        while (true) {
            PartHeader part;
            bool any = false;
            if (Status read = part_header(part, any); !read) return read.error();
            if (any) found.push_back(part);
            if (!many || !any) return found;
        }
    }

  private:
    bool take(char* target, std::size_t count) {
        if (count > left_) return false;
        left_ -= count;
        return static_cast<bool>(stream_.read(target, static_cast<std::streamsize>(count)));
    }

    /// Reads a text that ends in a zero byte. Names have at most 255 bytes.
    bool take_name(std::string& name) {
        name.clear();
        for (char c = 0; take(&c, 1); name += c) {
            if (c == '\0') return true;
            if (name.size() > 255) return false;
        }
        return false;
    }

    Status part_header(PartHeader& part, bool& any) {
        std::string name, type, value;
        while (true) {
            if (!take_name(name)) return damaged("has no end");
            if (name.empty()) return success();
            any = true;
            std::uint32_t size = 0;
            if (!take_name(type) || !take(reinterpret_cast<char*>(&size), 4)) return damaged("has no end");
            if (size > left_)
                return damaged("claims " + std::to_string(size) + " bytes for '" + name + "', " +
                               std::to_string(left_) + " are left");
            for (const FixedSize& each : fixed_sizes)
                if (type == each.type && size != each.bytes)
                    return damaged("claims " + std::to_string(size) + " bytes for '" + name + "' of type " + type +
                                   ", which has " + std::to_string(each.bytes));
            const bool wanted_here =
                type == "preview" || type == "box2i" || type == "chlist" || type == "compression" || name == "type";
            if (!wanted_here) {
                stream_.seekg(size, std::ios::cur);
                left_ -= size;
                continue;
            }
            value.resize(size);
            if (!take(value.data(), size)) return damaged("has no end");
            if (Status good = attribute(name, type, value, part); !good) return good;
        }
    }

    Status attribute(const std::string& name, const std::string& type, const std::string& value,
                     PartHeader& part) const {
        if (type == "box2i" && value.size() == sizeof(Box)) {
            Box* box = name == "dataWindow" ? &part.data : name == "displayWindow" ? &part.display : nullptr;
            if (box != nullptr) std::memcpy(box, value.data(), sizeof(Box));
        } else if (type == "compression" && value.size() == 1) {
            part.compression = static_cast<unsigned char>(value[0]);
        } else if (type == "chlist") {
            if (!channels(value, part)) return damaged("has a list of channels with a wrong end");
        } else if (type == "preview") {
            std::uint32_t size[2] = {};
            if (value.size() >= sizeof size) std::memcpy(size, value.data(), sizeof size);
            if (static_cast<double>(value.size()) != 8 + 4.0 * size[0] * size[1])
                return damaged("has a preview whose size does not match its header");
        } else if (name == "type") {
            part.deep = value.starts_with("deep");
        }
        return success();
    }

    /// Parses a list of name, pixel type, four bytes, x and y sampling. Returns false unless the list ends with its
    /// empty name, because the library searches for that name and not for the end.
    static bool channels(std::string_view list, PartHeader& part) {
        while (!list.empty() && list.front() != '\0') {
            const std::size_t end = list.find('\0');
            constexpr std::size_t fields = 16;
            if (end == std::string_view::npos || list.size() - end - 1 < fields) return false;
            std::int32_t field[4];
            std::memcpy(field, list.data() + end + 1, fields);
            const double samples =
                static_cast<double>(std::max(field[2], 1)) * static_cast<double>(std::max(field[3], 1));
            part.pixel_bytes += (field[0] == 1 ? 2.0 : 4.0) / samples;
            part.channels += 1;
            list.remove_prefix(end + 1 + fields);
        }
        return list.size() == 1;
    }

    Error damaged(const std::string& what) const {
        return failure(path_,
                       "the file is truncated or damaged: its header " + what + "; expected a whole OpenEXR file");
    }

    const std::string& path_;
    std::ifstream stream_;
    std::uint64_t left_;
};

/// The memory that the library needs for unpacking, even for few lines: two buffers of a chunk for each thread.
double chunk_buffers(const PartHeader& part) {
    constexpr std::array<double, 10> lines{1,  1,  1,  16, 32,
                                           16, 32, 32, 32, 256};  // by compression, "OpenEXR File Layout"
    const double width = static_cast<double>(part.data.max_x) - part.data.min_x + 1;
    const double chunk = (part.compression < lines.size() ? lines[part.compression] : 1) * width * part.pixel_bytes;
    return 2 * chunk * std::max(1, 2 * Imf::globalThreadCount());
}

/// Checks the memory that the header implies, which can be anything, against the file's size and the budgets.
Status check_pixels(const std::vector<PartHeader>& parts, std::uint64_t file_bytes, const std::string& path) {
    double plain = 0, stored = 0, memory = 0;
    for (const PartHeader& part : parts) {
        if (part.data.empty() || part.display.empty())
            return failure(path,
                           "the file is truncated or damaged: its image has no pixels; expected a whole OpenEXR file");
        const double pixels = std::max(part.data.pixels(), part.display.pixels());
        if (pixels > static_cast<double>(budget(Budget::image_pixels)))
            return over_budget(Budget::image_pixels,
                               "the header declares " + std::to_string(static_cast<std::uint64_t>(pixels)) + " pixels",
                               path);
        if (part.deep) continue;  // read one row at a time
        if (part.compression == 0) plain += part.data.pixels() * part.pixel_bytes;
        const double all = part.data.pixels() + (part.data == part.display ? 0 : part.display.pixels());
        stored += part.pixel_bytes * all;
        memory += 4 * part.channels * all + chunk_buffers(part);
    }
    const auto bytes = static_cast<double>(file_bytes);
    if (plain > bytes)
        return failure(path, "the file is truncated: its header declares " +
                                 std::to_string(static_cast<std::uint64_t>(plain)) +
                                 " bytes of uncompressed pixels, the file has " + std::to_string(file_bytes));
    constexpr double float_samples = 4;  // in memory a sample is a float: the floor allows as many samples as bytes
    if (memory <= float_samples * static_cast<double>(budget(Budget::unpack_floor)) ||
        stored <= bytes * static_cast<double>(budget(Budget::exr_ratio)))
        return success();
    return over_budget(Budget::exr_ratio,
                       "the header declares " + std::to_string(static_cast<std::uint64_t>(stored)) +
                           " bytes of pixels, which a file of " + std::to_string(file_bytes) +
                           " bytes cannot plausibly contain",
                       path);
}

}  // namespace

Status check_exr_file(const std::string& path) {
    if (Status regular = check_regular_file(path, wanted); !regular) return regular;
    std::error_code failed;
    const std::uint64_t size = std::filesystem::file_size(path, failed);
    if (failed) return failure(path, "cannot read this file: " + failed.message() + "; expected " + wanted);
    unsigned char magic[4] = {};
    std::ifstream stream(path, std::ios::binary);
    stream.read(reinterpret_cast<char*>(magic), 4);
    if (stream.gcount() != 4 || magic[0] != 0x76 || magic[1] != 0x2f || magic[2] != 0x31 || magic[3] != 0x01)
        return failure(path, size == 0 ? "the file is empty; expected an OpenEXR file"
                                       : "not an OpenEXR file; expected a file that begins with the bytes 76 2f 31 01");
    auto parts = HeaderReader(path, size).parts();
    if (!parts) return parts.error();
    return check_pixels(*parts, size, path);
}

}  // namespace raylex::display
