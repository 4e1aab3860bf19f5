// Writes and reads the record, the format of checkpoints, shards and experiment cells.
#include "display/buffer/frame_buffer/frame_buffer_storage.h"
#include "display/buffer/record_bytes.h"
#include "display/services/parameters.h"

#include <type_traits>

namespace raylex::display {
namespace {

/// Increase it with every change of the content of a record, except for planes, which have names.
constexpr std::uint32_t record_version = 6;

/// If this binding no longer compiles, ChannelDefinition has a new member that records do not contain yet.
void write_channel(RecordWriter& writer, const ChannelDefinition& definition) {
    const auto& [name, style, type, declared, expression, dialect, rest_of, rule, space, statistics, source, statistic,
                 miss_value, scale_exponent, origin, origin_line, origin_column] = definition;
    writer.text(name);
    writer.number(style);
    writer.number(type);
    writer.text(expression);
    writer.number(dialect);
    writer.numbers({rest_of.begin(), rest_of.end()});
    writer.number(rule);
    writer.text(space);
    writer.number(static_cast<std::uint8_t>(statistics));
    writer.number(source);
    writer.number(statistic);
    writer.number(miss_value);
    writer.number(scale_exponent);
    // `declared` only affects how a render finds the channel; the origin only appears in error messages.
    static_cast<void>(declared);
    static_cast<void>(origin), static_cast<void>(origin_line), static_cast<void>(origin_column);
}

template <class Enum>
Enum read_enum(RecordReader& reader, Enum last) {
    const auto value = reader.number<Enum>();
    if (value > last) reader.fail();
    return reader.ok() ? value : Enum{};
}

ChannelDefinition read_channel(RecordReader& reader) {
    ChannelDefinition definition;
    definition.name = reader.text();
    definition.style = read_enum(reader, ChannelStyle::expression);
    definition.type = read_enum(reader, ChannelType::integer);
    definition.expression = reader.text();
    definition.dialect = read_enum(reader, lpe::Dialect::osl);
    const std::vector<std::uint64_t> rest_of = reader.numbers();
    definition.rest_of.assign(rest_of.begin(), rest_of.end());
    definition.rule = read_enum(reader, FilterRule::sum);
    definition.space = reader.text();
    definition.statistics = reader.number<std::uint8_t>() != 0;
    definition.source = reader.number<ChannelId>();
    definition.statistic = read_enum(reader, Statistic::odd);
    definition.miss_value = reader.number<float>();
    definition.scale_exponent = reader.number<int>();
    return definition;
}

Error record_error(const std::string& found) {
    return error_at({}, "not a frame buffer record that this version of raylex supports: " + found);
}

/// Calls visit(name, plane, like) for every plane that exists, in the order of the storage's lists. `like` is an
/// earlier plane that often has equal content, or empty: if all weights are 1, weighted and unweighted sums are equal.
template <class Storage, class Visit>
void visit_planes(Storage& storage, Visit visit) {
    const std::span<const Int128> none;
    const auto present = [&](const std::string& name, auto& plane, std::span<const Int128> like) {
        if (!plane.empty()) visit(name, plane, like);
    };
    storage.for_each_plane([&](const char* name, auto plane) { present(name, storage.*plane, none); });
    for (auto& channel : storage.channels) {
        const std::span<const Int128> weighted = channel.sum.values();
        channel.for_each_plane([&](const char* name, auto plane) {
            const bool unweighted = &(channel.*plane) == static_cast<const void*>(&channel.plain_sum);
            present(channel.definition.name + "/" + name, channel.*plane, unweighted ? weighted : none);
        });
    }
}

}  // namespace

void FrameBuffer::append_record(std::string& bytes) const {
    append_record(bytes, 0, storage_->layout.height);
}

void FrameBuffer::append_record(std::string& bytes, int first, int end) const {
    const Storage& storage = *storage_;
    const auto rows = static_cast<std::size_t>(storage.layout.height);
    // The numbers of a plane for these rows. Numbers that exist once are in every band, so that each band can be
    // resolved.
    const auto of_rows = [&]<class T>(std::span<const T> values) {
        if (static_cast<const void*>(values.data()) == storage.light_paths.values().data()) return values;
        const std::size_t a_row = values.size() / rows;
        return values.subspan(static_cast<std::size_t>(first) * a_row, static_cast<std::size_t>(end - first) * a_row);
    };
    // Reserve address space for everything, so that nothing is copied twice; pages that stay zero cost no memory.
    std::size_t most = bytes.size() + 4096 * (storage.channels.size() + 1);
    visit_planes(storage, [&]<class T>(const std::string& name, const Plane<T>& plane, auto) {
        most += name.size() + of_rows(plane.values()).size_bytes() * 257 / 256 + 64;
    });
    bytes.reserve(most);
    RecordWriter writer(bytes);
    writer.number(record_version);
    writer.number(storage.layout.width);
    writer.number(end - first);
    writer.number(storage.layout.block_size);
    writer.number(storage.layout.quantum_exponent);
    writer.number(storage.layout.first_row + first);
    writer.text(storage.kernel_name);
    writer.text(storage.raster_kernel_name);
    writer.number(static_cast<std::uint64_t>(storage.channels.size()));
    for (const ChannelDefinition& definition : storage.definitions) write_channel(writer, definition);
    // The band with the first row has the counts, so that they count once.
    for (std::size_t i = 0; i <= storage.channels.size(); ++i)
        writer.number(first == 0 ? storage.rejected[i].load() : std::uint64_t{0});
    writer.number(storage.largest_light.load());
    visit_planes(storage, [&]<class T>(const std::string& name, const Plane<T>& plane, auto like) {
        writer.text(name);
        const std::span<const T> values = of_rows(plane.values());
        if constexpr (std::is_same_v<T, Int128>) writer.sums(values, like.empty() ? like : of_rows(like));
        else writer.plane({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
    });
}

/// Planes and checks depend on the modes, not on the kernels.
Result<FrameBuffer> FrameBuffer::of_kernels_by_name(const FrameBufferLayout& layout,
                                                    std::span<const ChannelDefinition> channels,
                                                    const std::string& kernel, const std::string& raster_kernel) {
    const FilterProfile box([](double) { return 1.0; }, 0.5, 1);
    const PixelFilter any("box", box, box);
    auto buffer = create(layout, channels, kernel.empty() ? nullptr : &any, raster_kernel.empty() ? nullptr : &any);
    if (!buffer) return buffer;
    buffer->storage_->kernel_name = kernel;
    buffer->storage_->raster_kernel_name = raster_kernel;
    return buffer;
}

Result<FrameBuffer> FrameBuffer::like(const FrameBufferLayout& layout) const {
    return of_kernels_by_name(layout, channels(), storage_->kernel_name, storage_->raster_kernel_name);
}

Status FrameBuffer::place(const FrameBuffer& band) {
    Storage& mine = *storage_;
    const Storage& theirs = *band.storage_;
    FrameBufferLayout layout = mine.layout;
    layout.height = theirs.layout.height;
    layout.first_row = theirs.layout.first_row;
    const auto alike = band.like(layout);
    const int first = layout.first_row - mine.layout.first_row;
    if (!alike || !alike->difference_from(band).empty() || first < 0 || first + layout.height > mine.layout.height)
        return error_at({}, "the band is not part of this image");
    const auto put = [&]<class T>(Plane<T>& to, const Plane<T>& from) {
        if (from.empty()) return;
        const auto rows = static_cast<std::size_t>(layout.height);
        const std::size_t at = to.size() == from.size() ? 0 : static_cast<std::size_t>(first) * (from.size() / rows);
        std::copy(from.values().begin(), from.values().end(), to.values().begin() + static_cast<std::ptrdiff_t>(at));
    };
    Storage::for_each_plane([&](const char*, auto plane) { put(mine.*plane, theirs.*plane); });
    for (std::size_t i = 0; i < mine.channels.size(); ++i)
        Channel::for_each_plane(
            [&](const char*, auto plane) { put(mine.channels[i].*plane, theirs.channels[i].*plane); });
    for (std::size_t i = 0; i <= mine.channels.size(); ++i) mine.rejected[i].fetch_add(theirs.rejected[i].load());
    mine.note_light(theirs.largest_light.load());
    return success();
}

Result<FrameBuffer> FrameBuffer::from_record(std::string_view bytes) {
    RecordReader reader(bytes);
    if (const auto version = reader.number<std::uint32_t>(); version != record_version)
        return record_error("version " + std::to_string(version) + "; expected " + std::to_string(record_version));
    FrameBufferLayout layout;
    layout.width = reader.number<int>();
    layout.height = reader.number<int>();
    layout.block_size = reader.number<int>();
    layout.quantum_exponent = reader.number<int>();
    layout.first_row = reader.number<int>();
    constexpr int longest_side = 1 << 20;  // so that no size below overflows
    if (layout.width > longest_side || layout.height > longest_side || layout.first_row < 0 ||
        layout.first_row > longest_side)
        return record_error("its size is out of range");
    const std::string kernel = reader.text(), raster_kernel = reader.text();
    const auto count = reader.number<std::uint64_t>();
    std::vector<ChannelDefinition> channels;
    for (std::uint64_t i = 0; i < count && reader.ok(); ++i) channels.push_back(read_channel(reader));
    if (!reader.ok()) return record_error("its list of channels is damaged or ends early");
    auto buffer = of_kernels_by_name(layout, channels, kernel, raster_kernel);
    if (!buffer) return buffer.error();
    Storage& storage = *buffer->storage_;
    for (std::size_t i = 0; i <= channels.size(); ++i) storage.rejected[i].store(reader.number<std::uint64_t>());
    storage.note_light(reader.number<double>());
    visit_planes(storage, [&]<class T>(const std::string& name, Plane<T>& plane, auto like) {
        if (reader.text() != name) reader.fail();
        if constexpr (std::is_same_v<T, Int128>) reader.sums(plane.values(), like);
        else reader.plane(plane.bytes());
    });
    if (!reader.at_end()) return record_error("its planes are different, end early or have extra bytes");
    return buffer;
}

void FrameBuffer::adopt_kernels(const FrameBuffer& other) {
    storage_->kernel = other.storage_->kernel;
    storage_->raster_kernel = other.storage_->raster_kernel;
}

}  // namespace raylex::display
