// PNG by libpng. Colour chunks (gAMA, iCCP) are ignored: the scene specifies the encoding.
#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstring>

#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

/// The state of libpng's callbacks. libpng leaves a failed call by longjmp, so objects that live across its calls are
/// stored here, outside the functions that call it.
struct Decoder {
    const std::string& content;
    std::size_t at = 0;
    std::string reason;
    png_structp png = nullptr;
    png_infop info = nullptr;
    int width = 0, height = 0, channels = 0;
    bool wide = false;  ///< 16 bits a sample
    std::vector<png_bytep> rows;

    explicit Decoder(const std::string& bytes) : content(bytes) {
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, fail, [](png_structp, png_const_charp) {});
        if (png != nullptr) info = png_create_info_struct(png);
    }
    ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
    Decoder(const Decoder&) = delete;
    Decoder& operator=(const Decoder&) = delete;

    [[noreturn]] static void fail(png_structp png, png_const_charp reason) {
        static_cast<Decoder*>(png_get_error_ptr(png))->reason = reason;
        png_longjmp(png, 1);
    }

    static void read(png_structp png, png_bytep bytes, std::size_t count) {
        auto& self = *static_cast<Decoder*>(png_get_io_ptr(png));
        if (count > self.content.size() - self.at) png_error(png, "the file ends within a chunk");
        std::memcpy(bytes, self.content.data() + self.at, count);
        self.at += count;
    }

    bool read_header() {
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_set_read_fn(png, this, read);
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
        png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // the budgets limit the size
        png_read_info(png, info);
        width = static_cast<int>(png_get_image_width(png, info));
        height = static_cast<int>(png_get_image_height(png, info));
        // The channels after read_rows() has expanded them. libpng reports them only after it has allocated a row.
        channels = png_get_color_type(png, info) == PNG_COLOR_TYPE_PALETTE ? 3 : png_get_channels(png, info);
        if (png_get_valid(png, info, PNG_INFO_tRNS) != 0) ++channels;
        wide = png_get_bit_depth(png, info) == 16;
        return true;
    }

    bool read_rows() {
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_set_expand(png);
        if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
        if (png_get_rowbytes(png, info) != row_bytes()) png_error(png, "its rows are not as long as its header states");
        png_read_image(png, rows.data());
        png_read_end(png, nullptr);
        return true;
    }

    [[nodiscard]] std::size_t row_bytes() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) * (wide ? 2 : 1);
    }

    template <class Sample>
    bool read_samples(std::vector<Sample>& samples) {
        const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
        samples.resize(row * static_cast<std::size_t>(height));
        rows.resize(static_cast<std::size_t>(height));
        for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = reinterpret_cast<png_bytep>(samples.data() + y * row);
        return read_rows();
    }
};

template <class Sample>
Result<Image> decode(Decoder& decoder, const std::string& path, const Encoding& encoding) {
    std::vector<Sample> samples;
    if (!decoder.read_samples(samples)) return undecodable("PNG: " + decoder.reason, path);
    return from_integers(decoder.width, decoder.height, decoder.channels, std::span<const Sample>(samples), encoding);
}

}  // namespace

Result<Image> read_png(const std::string& content, const std::string& path, const Encoding& encoding) {
    Decoder decoder(content);
    if (decoder.info == nullptr) return undecodable("libpng cannot start", path);
    if (!decoder.read_header()) return undecodable("PNG: " + decoder.reason, path);
    const std::uint64_t pixel_bytes = static_cast<std::uint64_t>(decoder.channels) * (decoder.wide ? 2 : 1);
    if (Status fits = check_unpacked_size(decoder.width, decoder.height, pixel_bytes, content.size(), path); !fits)
        return fits.error();
    return decoder.wide ? decode<std::uint16_t>(decoder, path, encoding)
                        : decode<std::uint8_t>(decoder, path, encoding);
}

}  // namespace raylex::transport
