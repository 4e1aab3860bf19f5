// The one file that compiles stb_image. Its warnings are not ours.
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_HDR
#include <stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <array>
#include <limits>
#include <memory>

#include "lpe/budgets.h"
#include "transport/import/image_readers.h"

namespace raylex::transport {

namespace {

struct StbFree {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

bool is_alpha(std::size_t sample, int channels) {
    return channels % 2 == 0 && static_cast<int>(sample % static_cast<std::size_t>(channels)) == channels - 1;
}

// stb_image reads zeros behind the end of a file, so a JPEG or TGA that was cut short decodes without complaint. The
// checks below find the cut: a JPEG ends its last scan with an end-of-image marker, a TGA's packets cover all pixels.

bool jpeg_is_whole(const std::string& content) {
    const std::size_t scan = content.rfind("\xff\xda"), end = content.rfind("\xff\xd9");
    return scan != std::string::npos && end != std::string::npos && end > scan;
}

bool tga_is_whole(const std::string& content) {
    constexpr std::size_t header = 18;
    if (content.size() < header) return false;
    const auto byte = [&content](std::size_t i) {
        return static_cast<std::size_t>(static_cast<unsigned char>(content[i]));
    };
    const std::size_t pixel = (byte(16) + 7) / 8, pixels = (byte(12) | byte(13) << 8) * (byte(14) | byte(15) << 8);
    std::size_t at = header + byte(0) + (byte(1) != 0 ? (byte(5) | byte(6) << 8) * ((byte(7) + 7) / 8) : 0);
    const bool run_length = byte(2) >= 8;
    if (!run_length) return content.size() >= at + pixels * pixel;
    for (std::size_t done = 0; done < pixels;) {
        if (at >= content.size()) return false;
        const std::size_t packet = byte(at), count = (packet & 127) + 1;
        at += 1 + pixel * (packet >= 128 ? 1 : count);
        done += count;
    }
    return at <= content.size();
}

/// Of an HDR file stb_image takes a run of no pixels for progress, and zeros behind the end for such runs: it would not
/// come back. Scanlines of runs begin with 2 2 and their width; others are plain pixels from there on.
bool hdr_is_whole(const std::string& content, int width, int height) {
    const std::size_t blank = content.find("\n\n");
    const std::size_t resolution = blank == std::string::npos ? blank : content.find('\n', blank + 2);
    if (resolution == std::string::npos) return false;
    std::size_t at = resolution + 1;
    const auto byte = [&content](std::size_t i) {
        return i < content.size() ? static_cast<int>(static_cast<unsigned char>(content[i])) : 0;
    };
    const auto plain = [&](int rows) {
        const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(rows);
        return content.size() >= at && (content.size() - at) / 4 >= pixels;
    };
    if (width < 8 || width >= 32'768) return plain(height);
    for (int row = 0; row < height; ++row) {
        if (byte(at) != 2 || byte(at + 1) != 2 || (byte(at + 2) & 0x80) != 0) return row == 0 && plain(height);
        at += 4;
        for (int left = 4 * width; left > 0;) {
            const int mark = byte(at), count = mark > 128 ? mark - 128 : mark;
            if (count == 0 || count > (left - 1) % width + 1) return false;
            at += mark > 128 ? 2 : 1 + static_cast<std::size_t>(count);
            if (at > content.size()) return false;
            left -= count;
        }
    }
    return true;
}

/// stb_image keeps 256 codes of a Huffman table and writes as many as a JPEG claims, up to 4080. Segments before the
/// first scan are passed over by their length, as they may hold anything; from there on any mark of a table is one.
bool jpeg_tables_fit(const std::string& content) {
    const auto byte = [&content](std::size_t i) {
        return i < content.size() ? static_cast<std::size_t>(static_cast<unsigned char>(content[i])) : 0;
    };
    constexpr std::size_t tables = 0xc4, scan = 0xda;
    bool scanned = false;
    for (std::size_t at = 2; at + 3 < content.size();) {
        if (byte(at) != 0xff || byte(at + 1) == 0xff) {
            ++at;
            continue;
        }
        const std::size_t marker = byte(at + 1), length = byte(at + 2) << 8 | byte(at + 3);
        if (marker == tables)
            // A table that begins within the segment is read to its end, wherever the segment ends.
            for (std::size_t table = at + 4; table < at + 2 + length;) {
                std::size_t codes = 0;
                for (std::size_t i = 1; i <= 16; ++i) codes += byte(table + i);
                if (codes > 256) return false;
                table += 17 + codes;
            }
        scanned = scanned || marker == scan;
        at += scanned || marker < 0xc0 || (marker >= 0xd0 && marker <= 0xd9) ? 2 : 2 + std::max<std::size_t>(length, 2);
    }
    return true;
}

/// Of a PNG stb_image takes as much memory for a chunk of pixels as the chunk claims, up to a gigabyte, before it
/// reads.
bool png_is_whole(const std::string& content) {
    constexpr std::size_t around = 12;  // length, type and checksum
    std::size_t at = 8;
    while (content.size() >= at + around) {
        std::size_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<unsigned char>(content[at + i]);
        if (length > content.size() - at - around) return false;
        if (content.compare(at + 4, 4, "IEND") == 0) return true;
        at += around + length;
    }
    return false;
}

/// The header's size against the budgets: a small file can unpack to gigabytes of one colour.
Status check_size(const stbi_uc* bytes, int size, const std::string& path) {
    int width = 0, height = 0, channels = 0;
    if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0) return success();  // the decoder says why
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    const std::string shown = "the image has " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
    if (pixels > budget(Budget::image_pixels)) return over_budget(Budget::image_pixels, shown, path);
    const bool wide = stbi_is_16_bit_from_memory(bytes, size) != 0;
    const std::uint64_t sample = stbi_is_hdr_from_memory(bytes, size) != 0 ? 4 : wide ? 2 : 1;
    const std::uint64_t unpacked = pixels * static_cast<std::uint64_t>(channels) * sample;
    if (unpacked <= budget(Budget::unpack_floor) ||
        unpacked / budget(Budget::unpack_ratio) <= static_cast<std::uint64_t>(size))
        return success();
    return over_budget(Budget::unpack_ratio, shown + " in " + std::to_string(size) + " bytes", path);
}

}  // namespace

Result<Image> read_with_stb(const std::string& content, const std::string& path, const Encoding& encoding) {
    const auto failure = [&path](const char* reason) {
        return Error{std::string("corrupt or unsupported image: ") + (reason != nullptr ? reason : "cannot decode"),
                     path,
                     0,
                     0,
                     {},
                     {}};
    };
    if (content.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return failure("larger than 2 GiB");
    if (content.compare(0, 2, "\xff\xd8") == 0 && !jpeg_is_whole(content))
        return failure("JPEG is truncated; expected an end-of-image marker");
    if (content.compare(0, 2, "\xff\xd8") == 0 && !jpeg_tables_fit(content))
        return failure("JPEG is damaged; expected at most 256 codes in a Huffman table");
    const bool tga = content.compare(0, 4, "\x89PNG") != 0 && content.compare(0, 2, "\xff\xd8") != 0 &&
                     content.compare(0, 2, "#?") != 0;
    if (tga && !tga_is_whole(content)) return failure("TGA is truncated; expected as many pixels as its header says");
    const auto* bytes = reinterpret_cast<const stbi_uc*>(content.data());
    const int size = static_cast<int>(content.size());
    if (Status fits = check_size(bytes, size, path); !fits) return fits.error();
    if (content.compare(0, 4, "\x89PNG") == 0 && !png_is_whole(content))
        return failure("PNG is truncated or damaged; expected chunks that end within the file");
    Image image;
    int &w = image.width, &h = image.height, &c = image.channels;
    const auto samples = [&] {
        return static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c);
    };

    if (stbi_is_hdr_from_memory(bytes, size) != 0) {
        if (stbi_info_from_memory(bytes, size, &w, &h, &c) != 0 && !hdr_is_whole(content, w, h))
            return failure("HDR is truncated or damaged; expected runs that fill each line");
        const std::unique_ptr<float, StbFree> pixels(stbi_loadf_from_memory(bytes, size, &w, &h, &c, 0));
        if (!pixels) return failure(stbi_failure_reason());
        image.pixels.assign(pixels.get(), pixels.get() + samples());
        return image;
    }
    if (stbi_is_16_bit_from_memory(bytes, size) != 0) {
        const std::unique_ptr<stbi_us, StbFree> pixels(stbi_load_16_from_memory(bytes, size, &w, &h, &c, 0));
        if (!pixels) return failure(stbi_failure_reason());
        image.pixels.resize(samples());
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const double stored = pixels.get()[i] / 65535.0;
            image.pixels[i] = is_alpha(i, c) ? static_cast<float>(stored) : encoding.decode(stored);
        }
        return image;
    }
    const std::unique_ptr<stbi_uc, StbFree> pixels(stbi_load_from_memory(bytes, size, &w, &h, &c, 0));
    if (!pixels) return failure(stbi_failure_reason());
    std::array<float, 256> table;
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = encoding.decode(static_cast<double>(i) / 255);
    image.pixels.resize(samples());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const stbi_uc stored = pixels.get()[i];
        image.pixels[i] = is_alpha(i, c) ? static_cast<float>(stored) / 255.0f : table[stored];
    }
    return image;
}

}  // namespace raylex::transport
