// Display filters process resolved pixels, after the pixel filter and before drivers. They do not affect deep images,
// statistics or the adaptive sampler.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/services/channel.h"
#include "display/services/registry.h"

namespace raylex::display {

/// One object serves all threads and is called for any region, repeatedly while an image is shown live. apply() may
/// change only the given pixels, and a pixel must not depend on the region that contains it.
class DisplayFilter {
  public:
    virtual ~DisplayFilter() = default;
    [[nodiscard]] virtual bool changes(ChannelId id) const = 0;
    [[nodiscard]] virtual bool changes_alpha() const { return false; }
    /// Changes the pixels of a channel for which changes() is true: in row order with interleaved components, initially
    /// the values of `before`. `before` is the result of the filters before this one; other channels and pixels can be
    /// read from it.
    virtual void apply(const PixelImage& before, ChannelId id, const PixelRegion& region,
                       std::span<double> pixels) const = 0;
    /// Changes the coverage of a region, if changes_alpha() is true.
    virtual void apply_alpha(const PixelImage& /*before*/, const PixelRegion& /*region*/,
                             std::span<double> /*alpha*/) const {}
    /// Channels that the filter changes differently from all light together, so that partitions containing them no
    /// longer sum. Such a partition is not declared in files, and a warning is shown. If a filter omits a channel here,
    /// its split is reported as not holding.
    [[nodiscard]] virtual std::vector<ChannelId> alters() const { return {}; }
};

/// The properties of the image for which a filter is made.
struct DisplayFilterContext {
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
};

using DisplayFilterFactory =
    std::function<Result<std::unique_ptr<DisplayFilter>>(const ParameterSet&, const DisplayFilterContext&)>;

/// "grade" (filters/grade.h, on resolved pixels) and "background" (the beauty over a colour; alpha becomes 1).
Registry<DisplayFilterFactory>& display_filter_registry();

/// Makes the filter of that name with these parameters. Errors, at the set's location: no such filter, a wrong or
/// unknown parameter.
Result<std::unique_ptr<DisplayFilter>> make_display_filter(const std::string& name, const ParameterSet& parameters,
                                                           const DisplayFilterContext& context);

/// An image after filters, applied in order. `image` and the filters must outlive it.
class FilteredImage final : public PixelImage {
  public:
    FilteredImage(const PixelImage& image, std::span<const std::unique_ptr<DisplayFilter>> filters);
    [[nodiscard]] const FrameBufferLayout& layout() const override { return last().layout(); }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return last().channels(); }
    [[nodiscard]] int band_end(int y) const override { return last().band_end(y); }
    using PixelImage::resolve;
    using PixelImage::resolve_alpha;
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override {
        return last().resolve(id, region);
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override {
        return last().resolve_alpha(region);
    }

  private:
    class Stage;
    [[nodiscard]] const PixelImage& last() const { return *images_.back(); }
    std::vector<std::unique_ptr<const PixelImage>> stages_;
    std::vector<const PixelImage*> images_;  // the image itself, then the image after each filter
};

}  // namespace raylex::display
