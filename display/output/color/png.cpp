// Writes PNG with libpng's simplified interface (8-bit sRGB with an sRGB chunk).
#include <png.h>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"

namespace raylex::display {

Result<std::vector<unsigned char>> encode_png(int width, int height, std::span<const unsigned char> rgb) {
    const auto pixels =
        static_cast<std::size_t>(width > 0 ? width : 0) * static_cast<std::size_t>(height > 0 ? height : 0);
    if (pixels == 0 || rgb.size() != pixels * 3) {
        Error error;
        error.message = "cannot encode a PNG image of " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels from " + std::to_string(rgb.size()) +
                        " bytes; expected 3 bytes for each of at least 1 x 1 pixels";
        return error;
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGB;
    std::vector<unsigned char> bytes(PNG_IMAGE_PNG_SIZE_MAX(image));
    png_alloc_size_t size = bytes.size();
    const bool encoded = png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) != 0;
    if (!encoded) {
        Error error;
        error.message = std::string("libpng could not encode the image: ") + image.message;
        png_image_free(&image);
        return error;
    }
    bytes.resize(size);
    return bytes;
}

Status write_png(const std::string& path, int width, int height, std::span<const unsigned char> rgb) {
    Result<std::vector<unsigned char>> bytes = encode_png(width, height, rgb);
    if (!bytes) {
        Error error = std::move(bytes).error();
        error.file = path;
        return error;
    }
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    if (!file->write(bytes->data(), bytes->size())) return file->failure();
    return file->commit();
}

}  // namespace raylex::display
