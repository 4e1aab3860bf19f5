#include "display/buffer/frame_buffer/banded_image.h"

#include <algorithm>

#include "display/services/parameters.h"

namespace raylex::display {

std::vector<RowRange> bands_of(const RowRange& from, int rows) {
    std::vector<RowRange> bands;
    for (int y = from.first; y < from.end; y += rows) bands.push_back({y, std::min(y + rows, from.end)});
    return bands;
}

BandedImage::BandedImage(const FrameBufferLayout& layout, std::vector<ChannelDefinition> channels,
                         const std::vector<RowRange>& bands, Load load)
    : layout_(layout), channels_(std::move(channels)), load_(std::move(load)) {
    int most = 1;
    for (const RowRange& rows : bands) most = std::max(most, rows.end - rows.first);
    int next = 0;
    const auto fill_up_to = [&](int end) {
        for (const RowRange& rows : bands_of({next, end}, most)) bands_.push_back({rows, true});
    };
    for (const RowRange& rows : bands) {
        fill_up_to(rows.first);
        bands_.push_back({rows, false});
        next = rows.end;
    }
    fill_up_to(layout.height);
}

int BandedImage::band_end(int y) const {
    for (const Band& band : bands_)
        if (y < band.rows.end) return band.rows.end;
    return layout_.height;
}

const FrameBuffer& BandedImage::band_of(int y) const {
    const auto holds = [y](const RowRange& rows) { return y >= rows.first && y < rows.end; };
    if (loaded_ && holds({loaded_->layout().first_row, loaded_->layout().first_row + loaded_->layout().height}))
        return *loaded_;
    loaded_.reset();  // free it before the next band allocates memory
    const auto band = std::find_if(bands_.begin(), bands_.end(), [&](const Band& each) { return holds(each.rows); });
    FrameBufferLayout layout = layout_;
    layout.first_row = band->rows.first;
    layout.height = band->rows.end - band->rows.first;
    auto loaded = band->empty ? FrameBuffer::create(layout, channels_) : load_(band->rows);
    if (!loaded) throw BandFailure(loaded.error());
    if (!(loaded->layout() == layout)) throw BandFailure(error_at({}, "a band of the image has the wrong rows"));
    loaded_ = *std::move(loaded);
    return *loaded_;
}

template <class Resolve>
std::vector<double> BandedImage::by_bands(const PixelRegion& region, std::size_t components, Resolve resolve) const {
    const std::lock_guard lock(mutex_);
    std::vector<double> result;
    result.reserve(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()) * components);
    for (int y = region.y0; y < region.y1;) {
        const FrameBuffer& band = band_of(y);
        const int first = band.layout().first_row, end = std::min(region.y1, first + band.layout().height);
        const std::vector<double> part = resolve(band, PixelRegion{region.x0, y - first, region.x1, end - first});
        if (y == region.y0 && end == region.y1) return part;
        result.insert(result.end(), part.begin(), part.end());
        y = end;
    }
    return result;
}

std::vector<double> BandedImage::resolve(ChannelId id, const PixelRegion& region) const {
    return by_bands(region, static_cast<std::size_t>(component_count(channels_[static_cast<std::size_t>(id)].type)),
                    [id](const FrameBuffer& band, const PixelRegion& part) { return band.resolve(id, part); });
}

std::vector<double> BandedImage::resolve_alpha(const PixelRegion& region) const {
    return by_bands(region, 1,
                    [](const FrameBuffer& band, const PixelRegion& part) { return band.resolve_alpha(part); });
}

Status BandedImage::append_record(std::string& bytes, const RowRange& rows) const {
    const std::lock_guard lock(mutex_);
    try {
        const FrameBuffer& band = band_of(rows.first);
        const int first = band.layout().first_row;
        if (rows.end <= first + band.layout().height) {
            band.append_record(bytes, rows.first - first, rows.end - first);
            return success();
        }
    } catch (const BandFailure& failure) { return failure.error(); }
    const auto all = joined(rows);
    if (!all) return all.error();
    all->append_record(bytes);
    return success();
}

/// The caller holds the lock.
Result<FrameBuffer> BandedImage::joined(const RowRange& rows) const {
    std::optional<FrameBuffer> all;
    try {
        for (int y = rows.first; y < rows.end;) {
            const FrameBuffer& band = band_of(y);
            const int first = band.layout().first_row, end = std::min(rows.end, first + band.layout().height);
            std::string bytes;
            band.append_record(bytes, y - first, end - first);
            auto part = FrameBuffer::from_record(bytes);
            if (!part || (y == rows.first && end == rows.end)) return part;
            if (!all) {
                FrameBufferLayout layout = part->layout();
                layout.first_row = rows.first;
                layout.height = rows.end - rows.first;
                auto made = part->like(layout);
                if (!made) return made;
                all = *std::move(made);
            }
            if (Status placed = all->place(*part); !placed) return placed.error();
            y = end;
        }
    } catch (const BandFailure& failure) { return failure.error(); }
    return *std::move(all);
}

}  // namespace raylex::display
