#include "display/output/atlas/packed_rows.h"

#include "display/services/parameters.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <numeric>
#include <utility>

#include <openexr.h>

namespace raylex::display {
namespace {

/// A damaged row must not allocate memory that no valid row needs: deflate packs at most 1,032 bytes into one (zlib's
/// technical details), run-length coding 64.
constexpr std::uint64_t most_row_bytes = std::uint64_t{1} << 30, most_packing = 1032;

Error damaged(const std::string& path, const std::string& what) {
    return error_at({path, 0, 0}, "the file is truncated or damaged: " + what);
}

/// Suppresses OpenEXR's messages: results carry the errors, and this file reports them.
void say_nothing(exr_const_context_t, exr_result_t, const char*) {}

/// A decoder of one row, freed on every way out.
class Decoder {
  public:
    Decoder(exr_const_context_t context, int part, const exr_chunk_info_t& chunk) : context_(context), part_(part) {
        result_ = exr_decoding_initialize(context, part, &chunk, &pipeline_);
        // OpenEXR 3.1.5 detects the processor's features on first use and stores them without a lock.
        static std::mutex choosing;
        if (result_ == EXR_ERR_SUCCESS) {
            const std::lock_guard lock(choosing);
            result_ = exr_decoding_choose_default_routines(context, part, &pipeline_);
        }
        pipeline_.unpack_and_convert_fn = nullptr;  // leave planes where they were unpacked
        pipeline_.decode_flags |= EXR_DECODE_SAMPLE_COUNTS_AS_INDIVIDUAL;
    }
    ~Decoder() { exr_decoding_destroy(context_, &pipeline_); }
    Decoder(const Decoder&) = delete;
    Decoder& operator=(const Decoder&) = delete;

    exr_result_t run() {
        if (result_ == EXR_ERR_SUCCESS) result_ = exr_decoding_run(context_, part_, &pipeline_);
        return result_;
    }
    [[nodiscard]] const std::byte* planes() const {
        return static_cast<const std::byte*>(pipeline_.unpacked_buffer != nullptr ? pipeline_.unpacked_buffer
                                                                                  : pipeline_.packed_buffer);
    }
    [[nodiscard]] const std::int32_t* sample_counts() const { return pipeline_.sample_count_table; }

  private:
    exr_const_context_t context_;
    int part_;
    exr_decode_pipeline_t pipeline_{};  // as EXR_DECODE_PIPELINE_INITIALIZER, about which clang warns
    exr_result_t result_ = EXR_ERR_SUCCESS;
};

}  // namespace

class PackedRows::File {
  public:
    File() = default;
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() { exr_finish(&context); }

    std::string path;
    std::uint64_t size = 0;
    exr_context_t context = nullptr;
};

struct PackedRows::Impl {
    Status find_channels();
    /// Finds a row and checks that it is inside the file; does not check the content that is read later.
    [[nodiscard]] Status find(int y, exr_chunk_info_t& chunk) const;
    [[nodiscard]] Status check(const exr_chunk_info_t& chunk) const;
    void place_planes(Row& row) const;

    std::shared_ptr<const File> file;
    int part = 0;
    bool deep = false, packed = false;
    std::size_t width = 0;
    int first = 0, last = 0;  // rows
    std::vector<Channel> channels;
};

Status PackedRows::Impl::find_channels() {
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    exr_attr_box2i_t window{};
    const exr_attr_chlist_t* list = nullptr;
    std::int32_t lines = 0;
    exr_compression_t compression = EXR_COMPRESSION_RLE;
    const exr_const_context_t context = file->context;
    const std::string& path = file->path;
    if (exr_get_storage(context, part, &storage) != EXR_ERR_SUCCESS ||
        exr_get_data_window(context, part, &window) != EXR_ERR_SUCCESS ||
        exr_get_channels(context, part, &list) != EXR_ERR_SUCCESS ||
        exr_get_compression(context, part, &compression) != EXR_ERR_SUCCESS ||
        exr_get_scanlines_per_chunk(context, part, &lines) != EXR_ERR_SUCCESS)
        return damaged(path, "its header cannot be read");
    if (lines != 1)
        return error_at({path, 0, 0}, "its rows are packed " + std::to_string(lines) +
                                          " together; expected each by itself, as raylex writes them (rle or zips)");
    deep = storage == EXR_STORAGE_DEEP_SCANLINE;
    packed = compression != EXR_COMPRESSION_NONE;
    // OpenEXR 3.1.5's core rejects the counts of such rows as damaged, although they are correct.
    if (deep && !packed)
        return error_at({path, 0, 0}, "its deep rows are not packed; expected rle, as raylex writes them, or zips");
    width = static_cast<std::size_t>(std::int64_t{window.max.x} - window.min.x + 1);
    first = window.min.y;
    last = window.max.y;
    for (int i = 0; i < list->num_channels; ++i) {
        const exr_attr_chlist_entry_t& entry = list->entries[i];
        if (entry.x_sampling != 1 || entry.y_sampling != 1) return damaged(path, "a channel skips pixels");
        channels.push_back({entry.name.str, entry.pixel_type == EXR_PIXEL_HALF    ? Type::half
                                            : entry.pixel_type == EXR_PIXEL_FLOAT ? Type::single
                                                                                  : Type::uint});
    }
    return success();
}

void PackedRows::Impl::place_planes(Row& row) const {
    row.offset_.clear();
    std::size_t at = 0;
    for (const Channel& channel : channels) {
        row.offset_.push_back(at);
        at += channel.bytes() * row.begin_.back();
    }
    row.bytes_.resize(at);
}

PackedRows::PackedRows(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PackedRows::~PackedRows() = default;

Result<std::shared_ptr<const PackedRows::File>> PackedRows::open_file(const std::string& path) {
    auto file = std::make_shared<File>();
    file->path = path;
    std::error_code failed;
    file->size = std::filesystem::file_size(path, failed);
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.error_handler_fn = say_nothing;
    how.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t result = exr_start_read(&file->context, path.c_str(), &how);
    if (result == EXR_ERR_FILE_ACCESS)
        return error_at({path, 0, 0}, std::string("cannot be opened: ") + std::strerror(errno));
    if (result == EXR_ERR_OUT_OF_MEMORY) return error_at({path, 0, 0}, "not enough memory for its header");
    if (result != EXR_ERR_SUCCESS) return damaged(path, exr_get_default_error_message(result));
    return std::shared_ptr<const File>(std::move(file));
}

Result<std::unique_ptr<PackedRows>> PackedRows::open(std::shared_ptr<const File> file, int part) {
    auto impl = std::make_unique<Impl>();
    impl->file = std::move(file);
    impl->part = part;
    if (Status found = impl->find_channels(); !found) return found.error();
    // Checks all rows, not only those that a question reads: otherwise a truncated file could give an answer without an
    // error.
    exr_chunk_info_t chunk{};
    for (int y = impl->first; y <= impl->last; ++y)
        if (Status found = impl->find(y, chunk); !found) return found.error();
    return std::unique_ptr<PackedRows>(new PackedRows(std::move(impl)));
}

std::span<const PackedRows::Channel> PackedRows::channels() const {
    return impl_->channels;
}

int PackedRows::plane(const std::string& name, Type type) const {
    for (std::size_t i = 0; i < impl_->channels.size(); ++i)
        if (impl_->channels[i].name == name && impl_->channels[i].type == type) return static_cast<int>(i);
    return -1;
}

/// Checks the fields of a row's leader that OpenEXR 3.1.5's core uses unchecked, which could leave memory
/// uninitialised.
Status PackedRows::Impl::check(const exr_chunk_info_t& chunk) const {
    if (chunk.data_offset > file->size || chunk.packed_size > file->size - chunk.data_offset)
        return damaged(file->path, "a row ends after the end of the file");
    if (chunk.unpacked_size > std::min(most_row_bytes, most_packing * chunk.packed_size))
        return damaged(file->path, "a row claims more bytes than any row can have");
    if (!packed && chunk.packed_size != chunk.unpacked_size)
        return damaged(file->path, "the size of a row does not match its pixels");
    if (deep && (chunk.sample_count_table_size == 0 || chunk.sample_count_table_size > 4 * width))
        return damaged(file->path, "the size of a row does not match its counts");
    return success();
}

Status PackedRows::Impl::find(int y, exr_chunk_info_t& chunk) const {
    if (const exr_result_t result = exr_read_scanline_chunk_info(file->context, part, y, &chunk);
        result != EXR_ERR_SUCCESS)
        return damaged(file->path, exr_get_default_error_message(result));
    return check(chunk);
}

Status PackedRows::read(int y, Row& row) const {
    const Impl& impl = *impl_;
    const std::string& path = impl.file->path;
    exr_chunk_info_t chunk{};
    if (Status good = impl.find(y, chunk); !good) return good;
    Decoder decoder(impl.file->context, impl.part, chunk);
    if (const exr_result_t result = decoder.run(); result != EXR_ERR_SUCCESS)
        return damaged(path, exr_get_default_error_message(result));
    row.begin_.assign(1, 0);
    std::uint64_t samples = 0;
    for (std::size_t x = 0; x < impl.width; ++x) {
        const std::int32_t count = impl.deep ? decoder.sample_counts()[x] : 1;
        samples += static_cast<std::uint64_t>(std::max(count, 0));
        if (count < 0 || samples > most_row_bytes) return damaged(path, "a row's counts are invalid");
        row.begin_.push_back(static_cast<std::uint32_t>(samples));
    }
    impl.place_planes(row);
    if (row.bytes_.size() != chunk.unpacked_size) return damaged(path, "the size of a row does not match its samples");
    if (!row.bytes_.empty()) std::memcpy(row.bytes_.data(), decoder.planes(), row.bytes_.size());
    return success();
}

}  // namespace raylex::display
