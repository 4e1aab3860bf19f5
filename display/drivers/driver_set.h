// All drivers of one render, and the updates of the live ones.
//
// Regions are resolved in slices of at most slice_pixels, layer by layer and repeatedly, on the thread that reports
// progress. Updates stop when they have used live_share of the time since rendering began, so a viewer costs a render
// at most that fraction of one processor.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "display/drivers/display_driver.h"

namespace raylex::display {

/// The source of live pixels: PixelImage::resolve() and resolve_alpha().
struct PixelSource {
    std::function<std::vector<double>(ChannelId, const PixelRegion&)> resolve;
    std::function<std::vector<double>(const PixelRegion&)> resolve_alpha;
};

class DriverSet {
  public:
    static constexpr double live_share = 0.02;
    static constexpr int slice_pixels = 1 << 15;
    /// How long close() waits for a live driver that accepts no slice of the finished image.
    static constexpr double patience_seconds = 2;
    /// How long close() waits for one live driver to accept all slices of the finished image.
    static constexpr double longest_seconds = 10;

    void add(std::unique_ptr<DisplayDriver> driver) { drivers_.push_back(std::move(driver)); }
    [[nodiscard]] std::size_t size() const { return drivers_.size(); }
    [[nodiscard]] bool any_live() const;

    /// Opens all drivers. The first error closes none of them, because nothing is written yet.
    Status open(const DriverImage& image);
    /// Updates live drivers; call it regularly while the image grows. `seconds` since rendering began.
    void update(double seconds, double fraction, const PixelSource& source);
    /// Sends the finished image to live drivers and closes all drivers in order. Returns the first error after closing
    /// all.
    Status close(const FinishedImage& image);
    /// Warnings since the last call; at most one per driver overall.
    std::vector<std::string> take_warnings();
    [[nodiscard]] std::vector<std::string> files() const;

  private:
    struct Slice {
        std::size_t layer = 0;
        PixelRegion region;
    };
    [[nodiscard]] std::vector<float> values_of(const Slice& slice, const PixelSource& source) const;
    bool send(const Slice& slice, const PixelSource& source);
    void finish_live(DisplayDriver& driver, const PixelSource& source) const;
    void finish_live(const PixelImage& frame_buffer);
    std::vector<std::unique_ptr<DisplayDriver>> drivers_;
    std::vector<bool> warned_;
    DriverImage image_;
    std::vector<Slice> slices_;
    std::size_t next_ = 0;
    double spent_seconds_ = 0;
};

}  // namespace raylex::display
