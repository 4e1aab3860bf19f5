#include "transport/import/input_file.h"

#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

namespace raylex::transport {

namespace fs = std::filesystem;

namespace {

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

Error file_error(const std::string& path, std::string message) {
    return {std::move(message), path, 0, 0, {}, {}};
}

Result<std::string> read_bytes(const std::string& path) {
    std::error_code status;
    if (fs::is_directory(path, status)) return file_error(path, "is a folder; expected a file");
    errno = 0;
    const std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path.c_str(), "rb"));
    if (!file) return file_error(path, std::string("cannot open file: ") + std::strerror(errno));
    std::string content;
    if (const auto size = fs::file_size(path, status); !status) content.reserve(size + 1);
    std::array<char, 1 << 16> block;
    while (true) {
        const std::size_t count = std::fread(block.data(), 1, block.size(), file.get());
        content.append(block.data(), count);
        if (count < block.size()) break;
    }
    if (std::ferror(file.get()) != 0) return file_error(path, std::string("cannot read file: ") + std::strerror(errno));
    return content;
}

/// Inflates one gzip stream or several in a row (gzip allows concatenation).
Result<std::string> inflate_gzip(const std::string& path, const std::string& compressed) {
    z_stream stream{};
    constexpr int gzip_only = 16 + MAX_WBITS;
    if (inflateInit2(&stream, gzip_only) != Z_OK) return file_error(path, "cannot start decompression");
    const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);

    std::string content;
    content.resize(std::max<std::size_t>(compressed.size() * 3, 1 << 12));
    std::size_t used = 0, consumed = 0;
    while (true) {
        if (used == content.size()) content.resize(content.size() * 2);
        // zlib counts in unsigned int: hand over at most 1 GiB at a time.
        constexpr std::size_t most = std::size_t{1} << 30;
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

Result<std::string> read_file(const std::string& path) {
    Result<std::string> content = read_bytes(path);
    const bool gzip = content && content->size() > 1 && (*content)[0] == '\x1f' && (*content)[1] == '\x8b';
    if (!gzip) return content;
    return inflate_gzip(path, *content);
}

Result<std::string> SearchPath::find(const std::string& name, const SourceLocation& where) const {
    if (name.empty()) return error_at(where, "empty file name; expected the path of a file");
    if (name.find('\0') != std::string::npos) return error_at(where, "file name holds a zero byte");
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
