// Raster splats: light that lands where its path leads, not where a camera sample was drawn.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer_storage.h"
#include "display/buffer/raster_footprint.h"

namespace raylex::display {
long double FrameBuffer::Storage::raster_scale() const {
    if (light_paths.empty()) return 0;
    // Live views read while other threads count; atomic_ref needs a non-const object.
    const std::uint64_t paths =
        std::atomic_ref(const_cast<std::uint64_t&>(light_paths[0])).load(std::memory_order_relaxed);
    if (paths == 0) return 0;
    return std::ldexp(static_cast<long double>(pixel_count()) / static_cast<long double>(paths),
                      layout.quantum_exponent);
}

void FrameBuffer::count_light_paths(std::uint64_t paths) {
    std::atomic_ref(storage_->light_paths[0]).fetch_add(paths, std::memory_order_relaxed);
}

bool FrameBuffer::takes_raster_splats() const {
    return !storage_->raster_kernel_name.empty();
}

std::uint64_t FrameBuffer::light_path_count() const {
    return storage_->light_paths.empty() ? 0
                                         : std::atomic_ref(storage_->light_paths[0]).load(std::memory_order_relaxed);
}

void FrameBuffer::splat(const SampleTable& table, std::span<const int> rows) {
    Storage& storage = *storage_;
    const PixelFilter& kernel = *storage.raster_kernel;
    const FrameBufferLayout& layout = storage.layout;
    struct Part {
        Channel* channel;
        std::size_t index;
        const double* values;
    };
    std::vector<Part> parts;  // only few channels take a splat: find them once, not for every pixel
    parts.reserve(storage.raster_channels.size());
    for (const int row : rows) {
        parts.clear();
        for (const std::size_t index : storage.raster_channels) {
            Channel& channel = storage.channels[index];
            if (!table.touched(channel.samples_of)) continue;
            const double* values = table.values(channel.samples_of) + 3 * static_cast<std::size_t>(row);
            if (values[0] != 0 || values[1] != 0 || values[2] != 0) parts.push_back({&channel, index, values});
        }
        if (parts.empty()) continue;
        for_each_reached(
            kernel, table.camera_row(row), layout.width, layout.height, [&](std::size_t pixel, double weight) {
                for (const auto& [channel, index, values] : parts) {
                    const std::array<double, 3> terms{weight * values[0], weight * values[1], weight * values[2]};
                    storage.add(channel->raster_sum, 3 * pixel, terms.data(), 3, storage.exponents[index], index);
                }
            });
    }
}

}  // namespace raylex::display
