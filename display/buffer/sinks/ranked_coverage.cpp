#include "display/buffer/sinks/ranked_coverage.h"

#include <algorithm>
#include <limits>
#include <string>

#include "display/buffer/ray_rows.h"
#include "display/buffer/record_bytes.h"
#include "display/services/parameters.h"

namespace raylex::display {
namespace {

constexpr double unit = 4294967296.0;  // 2^32

/// The finaliser of MurmurHash3: a bijection, so different ids are never equal.
std::uint32_t mixed(std::uint32_t h) {
    h ^= h >> 16;
    h *= 0x85ebca6bU;
    h ^= h >> 13;
    h *= 0xc2b2ae35U;
    return h ^ (h >> 16);
}

/// Converts a weight to units, rounded to nearest, halves up, without a call of the C library. Negative weights and NaN
/// become 0; weights that are too large are clamped to the maximum of a pixel.
std::uint64_t to_units(double weight) {
    if (!(weight > 0)) return 0;
    const double units = std::min(weight * unit, 9.0e18);
    const auto whole = static_cast<std::uint64_t>(units);
    return whole + (units - static_cast<double>(whole) >= 0.5 ? 1 : 0);
}

void add_saturated(std::uint64_t& sum, std::uint64_t term) {
    if (__builtin_add_overflow(sum, term, &sum)) sum = std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

RankedCoverage::RankedCoverage(int width, int height, std::vector<std::uint32_t> ids)
    : width_(width),
      height_(height),
      ids_(std::move(ids)),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void RankedCoverage::add_to(Pixel& pixel, std::uint32_t id, std::uint64_t weight) {
    if (weight == 0) return;
    if (id == 0) return add_saturated(pixel.remainder, weight);
    Entry* const begin = pixel.entries.get();
    Entry* const end = begin + pixel.count;
    // The list is short, and usually the id is that of the previous sample. The order by mixed id only matters when a
    // list overflows.
    Entry* const at = std::lower_bound(
        begin, end, id, [](const Entry& entry, std::uint32_t other) { return mixed(entry.id) < mixed(other); });
    if (at != end && at->id == id) return add_saturated(at->weight, weight);
    const auto index = static_cast<std::size_t>(at - begin);
    if (pixel.count == ids_per_pixel) {
        if (index == ids_per_pixel) return add_saturated(pixel.remainder, weight);
        add_saturated(pixel.remainder, end[-1].weight);
        --pixel.count;
    } else if (pixel.count == pixel.capacity) {
        const std::uint32_t capacity = pixel.capacity == 0 ? 1 : 2 * pixel.capacity;
        auto larger = std::make_unique<Entry[]>(capacity);
        std::copy_n(begin, pixel.count, larger.get());
        pixel.entries = std::move(larger);
        pixel.capacity = capacity;
    }
    Entry* const list = pixel.entries.get();
    std::move_backward(list + index, list + pixel.count, list + pixel.count + 1);
    list[index] = {id, weight};
    ++pixel.count;
}

void RankedCoverage::add(std::size_t pixel, std::uint32_t id, double filter_weight, double visibility) {
    add_to(pixels_[pixel], id, to_units(filter_weight * visibility));
}

void RankedCoverage::add_weight(std::size_t pixel, double filter_weight) {
    add_saturated(pixels_[pixel].weight, to_units(filter_weight));
}

void RankedCoverage::accumulate(const SampleTable& table) {
    if (table.discarded()) return;
    thread_local RayRows rays;
    rays.gather(table);
    // Samples of a pixel are consecutive and usually see one object: its coverage is added to the pixel once.
    std::size_t at = 0;
    Entry seen;
    const auto put = [&] {
        if (seen.weight > 0) add_to(pixels_[at], seen.id, seen.weight);
    };
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const CameraRow& camera = table.camera_row(row);
        if (camera.pixel_x < 0 || camera.pixel_y < 0 || camera.pixel_x >= width_ || camera.pixel_y >= height_) continue;
        const auto pixel = static_cast<std::size_t>(camera.pixel_y) * static_cast<std::size_t>(width_) +
                           static_cast<std::size_t>(camera.pixel_x);
        const double weight = static_cast<double>(camera.filter_weight);
        add_weight(pixel, weight);
        const std::span<const int> rows = rays.of(row);
        const std::span<const double> coverage = rays.coverage(row);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (coverage[i] == 0) continue;
            const auto surface = static_cast<std::size_t>(table.surface[static_cast<std::size_t>(rows[i])]);
            const std::uint32_t id = surface < ids_.size() ? ids_[surface] : 0;
            if (pixel != at || id != seen.id) {
                put();
                at = pixel;
                seen = {id, 0};
            }
            add_saturated(seen.weight, to_units(weight * coverage[i]));
        }
    }
    put();
}

Status RankedCoverage::merge(const RankedCoverage& other) {
    if (width_ != other.width_ || height_ != other.height_)
        return error_at({}, "coverage of " + std::to_string(width_) + " x " + std::to_string(height_) + " and of " +
                                std::to_string(other.width_) + " x " + std::to_string(other.height_) +
                                " pixels cannot be merged");
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const Record theirs = other.record(i);
        add_saturated(pixels_[i].weight, theirs.weight);
        add_saturated(pixels_[i].remainder, theirs.remainder);
        for (const Entry& entry : theirs.entries) add_to(pixels_[i], entry.id, entry.weight);
    }
    return success();
}

RankedCoverage::Record RankedCoverage::record(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    return {p.weight, p.remainder, {p.entries.get(), p.count}};
}

void RankedCoverage::restore(std::size_t pixel, const Record& record) {
    Pixel restored;
    restored.weight = record.weight;
    restored.remainder = record.remainder;
    for (const Entry& entry : record.entries) add_to(restored, entry.id, entry.weight);
    pixels_[pixel] = std::move(restored);
}

void RankedCoverage::append_record(std::string& bytes) const {
    RecordWriter writer(bytes);
    writer.number(width_);
    writer.number(height_);
    for (const Pixel& pixel : pixels_) {
        writer.number(pixel.weight);
        writer.number(pixel.remainder);
        writer.number(pixel.count);
        for (std::uint32_t i = 0; i < pixel.count; ++i) {
            writer.number(pixel.entries[i].id);
            writer.number(pixel.entries[i].weight);
        }
    }
}

Status RankedCoverage::restore_record(std::string_view bytes) {
    RecordReader reader(bytes);
    bool fits = reader.number<int>() == width_;
    fits = reader.number<int>() == height_ && fits;
    if (!fits)
        return error_at(
            {}, "not a record of coverage of " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels");
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < pixels_.size() && reader.ok(); ++i) {
        Record record;
        record.weight = reader.number<std::uint64_t>();
        record.remainder = reader.number<std::uint64_t>();
        const auto count = reader.number<std::uint32_t>();
        if (count > ids_per_pixel) reader.fail();
        entries.clear();
        for (std::uint32_t k = 0; k < count && reader.ok(); ++k) {
            const auto id = reader.number<std::uint32_t>();
            entries.push_back({id, reader.number<std::uint64_t>()});
        }
        record.entries = entries;
        restore(i, record);
    }
    if (!reader.at_end()) return error_at({}, "the record of coverage ends early, or has extra bytes");
    return success();
}

std::size_t RankedCoverage::memory_bytes() const {
    std::size_t bytes = pixels_.size() * sizeof(Pixel) + ids_.size() * sizeof(std::uint32_t);
    for (const Pixel& pixel : pixels_) bytes += pixel.capacity * sizeof(Entry);
    return bytes;
}

double RankedCoverage::resolve(std::size_t pixel, std::span<Rank> ranks) const {
    std::fill(ranks.begin(), ranks.end(), Rank());
    const Record all = record(pixel);
    if (all.weight == 0) return 0;
    std::array<const Entry*, ids_per_pixel> sorted;  // uninitialised: most pixels have one or two ids
    const auto end = std::transform(all.entries.begin(), all.entries.end(), sorted.begin(),
                                    [](const Entry& entry) { return &entry; });
    std::sort(sorted.begin(), end, [](const Entry* a, const Entry* b) {
        return a->weight != b->weight ? a->weight > b->weight : a->id < b->id;
    });
    const double total = static_cast<double>(all.weight);
    double remainder = static_cast<double>(all.remainder);
    for (std::size_t i = 0; i < all.entries.size(); ++i) {
        const double weight = static_cast<double>(sorted[i]->weight);
        if (i < ranks.size()) ranks[i] = {sorted[i]->id, weight / total};
        else remainder += weight;
    }
    return remainder / total;
}

void RankedCoverage::for_each_id(const std::function<void(std::uint32_t)>& visit) const {
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        for (const Entry& entry : record(i).entries) visit(entry.id);
}

}  // namespace raylex::display
