#include "display/drivers/driver_set.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

namespace raylex::display {

namespace {

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

float live_value(double value) {
    if (std::isnan(value)) return 0;
    if (std::isinf(value)) return static_cast<float>(value);  // a miss value of the channel
    constexpr double largest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value, -largest, largest));
}

}  // namespace

bool DriverSet::any_live() const {
    return std::any_of(drivers_.begin(), drivers_.end(), [](const auto& driver) { return driver->is_live(); });
}

Status DriverSet::open(const DriverImage& image) {
    image_ = image;
    warned_.assign(drivers_.size(), false);
    for (auto& driver : drivers_)
        if (Status opened = driver->open(image_); !opened) return opened;
    slices_.clear();
    next_ = 0;
    spent_seconds_ = 0;
    if (!any_live()) return success();
    const int rows = std::max(1, slice_pixels / std::max(1, image.width));
    for (std::size_t layer = 0; layer < image.layers.size(); ++layer)
        for (int y = 0; y < image.height; y += rows)
            slices_.push_back({layer, {0, y, image.width, std::min(y + rows, image.height)}});
    return success();
}

std::vector<float> DriverSet::values_of(const Slice& slice, const PixelSource& source) const {
    const DriverLayer& layer = image_.layers[slice.layer];
    const std::vector<double> pixels = source.resolve(layer.channel, slice.region);
    const std::vector<double> alpha = layer.alpha ? source.resolve_alpha(slice.region) : std::vector<double>();
    const std::size_t planes = layer.planes.size(), components = planes - (layer.alpha ? 1 : 0);
    std::vector<float> values(pixels.size() / components * planes);
    for (std::size_t i = 0; i < pixels.size() / components; ++i) {
        for (std::size_t c = 0; c < components; ++c) values[i * planes + c] = live_value(pixels[i * components + c]);
        if (layer.alpha) values[i * planes + components] = live_value(alpha[i]);
    }
    return values;
}

bool DriverSet::send(const Slice& slice, const PixelSource& source) {
    const std::vector<float> values = values_of(slice, source);
    bool taken = true;
    for (auto& driver : drivers_)
        if (driver->is_live()) taken = driver->region({slice.layer, slice.region, values}) && taken;
    return taken;
}

void DriverSet::update(double seconds, double fraction, const PixelSource& source) {
    for (auto& driver : drivers_) driver->progress(fraction);
    if (slices_.empty() || !any_live()) return;
    while (spent_seconds_ < live_share * seconds) {
        const double begin = now();
        const bool taken = send(slices_[next_], source);
        next_ = (next_ + 1) % slices_.size();
        spent_seconds_ += now() - begin;
        if (!taken) break;  // no room: further regions would be dropped too
    }
}

void DriverSet::finish_live(const PixelImage& frame_buffer) {
    if (slices_.empty()) return;
    const PixelSource source{[&](ChannelId id, const PixelRegion& region) { return frame_buffer.resolve(id, region); },
                             [&](const PixelRegion& region) { return frame_buffer.resolve_alpha(region); }};
    for (auto& driver : drivers_) finish_live(*driver, source);
}

/// Sends all slices to one driver, so that a slow viewer costs the others nothing. Gives up when the driver accepts no
/// slice for patience_seconds.
void DriverSet::finish_live(DisplayDriver& driver, const PixelSource& source) const {
    const double last = now() + longest_seconds;
    for (const Slice& slice : slices_) {
        if (!driver.is_live()) return;
        const std::vector<float> values = values_of(slice, source);
        const double deadline = std::min(now() + patience_seconds, last);
        while (!driver.region({slice.layer, slice.region, values})) {
            if (now() > deadline) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }
}

Status DriverSet::close(const FinishedImage& image) {
    finish_live(image.frame_buffer);
    std::optional<Error> failure;
    for (auto& driver : drivers_) {
        Status closed = driver->close(image);
        if (!closed && !failure) failure = closed.error();
    }
    if (failure) return *failure;
    return success();
}

std::vector<std::string> DriverSet::take_warnings() {
    std::vector<std::string> fresh;
    warned_.resize(drivers_.size(), false);
    for (std::size_t i = 0; i < drivers_.size(); ++i) {
        if (warned_[i]) continue;
        std::string warning = drivers_[i]->warning();
        if (warning.empty()) continue;
        warned_[i] = true;
        fresh.push_back(std::move(warning));
    }
    return fresh;
}

std::vector<std::string> DriverSet::files() const {
    std::vector<std::string> files;
    for (const auto& driver : drivers_)
        if (!driver->file().empty()) files.push_back(driver->file());
    return files;
}

}  // namespace raylex::display
