#include "transport/files/input_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <system_error>

namespace raylex::transport {

namespace fs = std::filesystem;

namespace {

Error file_error(const std::string& path, std::string message) {
    return {std::move(message), path, 0, 0, {}, {}};
}

/// The unpacked size, modulo 2^32, from gzip's last four bytes. It is wrong for several streams or a forged file.
std::size_t claimed_size(const std::string& compressed) {
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < 4; ++i)
        size |= static_cast<std::uint32_t>(static_cast<unsigned char>(compressed[compressed.size() - 4 + i])) << 8 * i;
    return size;
}

/// Checks the unpacked size: a gzip file of a few megabytes can unpack to gigabytes of one byte.
Status check_unpacked(std::uint64_t unpacked, std::uint64_t compressed, const std::string& path) {
    const std::string shown = "the file of " + std::to_string(compressed) + " bytes unpacks to more than ";
    if (unpacked > budget(Budget::file_bytes))
        return over_budget(Budget::file_bytes, shown + std::to_string(budget(Budget::file_bytes)) + " bytes", path);
    const std::uint64_t ratio = budget(Budget::unpack_ratio);
    if (unpacked <= budget(Budget::unpack_floor) || unpacked / ratio <= compressed) return success();
    return over_budget(Budget::unpack_ratio, shown + std::to_string(ratio) + " times its size", path);
}

/// Inflates one gzip stream or several concatenated ones.
Result<std::string> inflate_gzip(const std::string& path, const std::string& compressed) {
    z_stream stream{};
    constexpr int gzip_only = 16 + MAX_WBITS;
    if (inflateInit2(&stream, gzip_only) != Z_OK) return file_error(path, "cannot start decompression");
    const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);

    const std::size_t claimed = claimed_size(compressed);
    const bool plausible = check_unpacked(claimed, compressed.size(), path).ok();
    std::string content;
    content.resize((plausible ? claimed : 1 << 20) + 1);  // one byte more, so that the end is found without growing
    std::size_t used = 0, consumed = 0;
    while (true) {
        if (used == content.size()) content.resize(content.size() * 2);
        if (reading_stopped()) return reading_stopped_error(path);
        if (Status fits = check_unpacked(used, compressed.size(), path); !fits) return fits.error();
        constexpr std::size_t most = std::size_t{1} << 22;  // per call, so that an interrupt stops the loop
        const std::size_t room = std::min(content.size() - used, most),
                          offered = std::min(compressed.size() - consumed, most);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data() + consumed));
        stream.avail_in = static_cast<uInt>(offered);
        stream.next_out = reinterpret_cast<Bytef*>(content.data() + used);
        stream.avail_out = static_cast<uInt>(room);
        const int code = inflate(&stream, Z_NO_FLUSH);
        consumed += offered - stream.avail_in;
        used += room - stream.avail_out;
        if (code == Z_STREAM_END) {
            if (consumed == compressed.size()) break;
            if (inflateReset2(&stream, gzip_only) != Z_OK) return file_error(path, "cannot continue decompression");
        } else if (code == Z_BUF_ERROR || (code == Z_OK && consumed == compressed.size() && stream.avail_out > 0)) {
            return file_error(path, "truncated gzip file: ends after " + std::to_string(compressed.size()) +
                                        " bytes; expected the end of the compressed stream");
        } else if (code != Z_OK) {
            return file_error(path, "corrupt gzip file near byte " + std::to_string(consumed) + ": " +
                                        (stream.msg != nullptr ? stream.msg : "invalid data"));
        }
    }
    content.resize(used);
    return content;
}

}  // namespace

Result<std::string> read_file(const std::string& path, NamedBy by, const std::string& expected) {
    Result<std::string> content = read_input(path, by, expected, Budget::file_bytes);
    const bool gzip = content && content->size() > 4 && (*content)[0] == '\x1f' && (*content)[1] == '\x8b';
    if (!gzip) return content;
    Result<std::string> unpacked = inflate_gzip(path, *content);
    if (unpacked) drop_byte_order_mark(*unpacked);
    return unpacked;
}

Result<std::string> SearchPath::find(const std::string& name, const SourceLocation& where) const {
    if (name.empty()) return error_at(where, "empty file name; expected the path of a file");
    if (name.find('\0') != std::string::npos) return error_at(where, "file name contains a zero byte");
    std::error_code status;
    for (const fs::path& folder : {scene_folder, local_folder}) {
        const fs::path candidate = folder / name;
        if (!fs::exists(candidate, status)) continue;
        const fs::path absolute = fs::absolute(candidate, status);
        return (status ? candidate : absolute.lexically_normal()).string();
    }
    std::string folders = "looked in " + (scene_folder.empty() ? "." : scene_folder.string());
    if (local_folder != scene_folder) folders += " and " + local_folder.string();
    return error_at(where, "cannot find file '" + name + "'", folders);
}

}  // namespace raylex::transport
