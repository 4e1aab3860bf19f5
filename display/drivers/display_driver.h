// Display drivers: where an image goes. Files, viewers and plugins come through this one door; a render has any number
// of them at once.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/output/writer/exr_writer.h"
#include "display/services/object_request.h"
#include "display/services/registry.h"

namespace raylex::display {

class ColorManager;

/// One layer as a driver sees it: beauty first (with alpha as its last plane), then the channels in their order.
struct DriverLayer {
    std::string name;  ///< "" for beauty
    ChannelId channel = invalid_channel;
    ChannelType type = ChannelType::rgb;
    std::vector<std::string> planes;  ///< names as in an OpenEXR file: R G B A, diffuse.R ..., Z
    bool alpha = false;
};

/// What is known before the first sample.
struct DriverImage {
    std::string title;  ///< the output's file name; what a viewer may call the image
    int width = 0, height = 0;
    std::vector<DriverLayer> layers;
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
    Chromaticities chromaticities;
    std::vector<PartitionDeclaration> partitions;
};

/// The pixels of one layer in a region, row by row, planes interleaved: scene-linear, never NaN. Infinite where a
/// channel's miss value is.
struct DriverRegion {
    std::size_t layer = 0;  ///< index in DriverImage::layers
    PixelRegion region;
    std::span<const float> values;
};

/// The image in the end; `description.complete` says whether all samples are in it.
struct FinishedImage {
    const PixelImage& frame_buffer;
    ChannelId beauty = invalid_channel;
    const ImageDescription& description;
};

/// Called from one thread: open, then region and progress while the render goes on (region only for live drivers), then
/// close. No call may wait for anything outside the program but in close, and there not for long.
class DisplayDriver {
  public:
    virtual ~DisplayDriver() = default;
    /// An Error ends the render before it begins: a file that cannot be written, a layer that is not there.
    virtual Status open(const DriverImage& image) = 0;
    /// Whether region() is wanted: of the image as it grows, and of the whole image once more before close().
    [[nodiscard]] virtual bool is_live() const { return false; }
    /// False when the driver has no room now; the region comes again later, with newer values.
    virtual bool region(const DriverRegion& /*region*/) { return true; }
    virtual void progress(double /*fraction*/) {}
    virtual Status close(const FinishedImage& image) = 0;
    /// What went wrong and does not concern the image, empty when nothing did; asked again and again, shown once.
    [[nodiscard]] virtual std::string warning() const { return {}; }
    /// The file it leaves, for the summary; empty for none.
    [[nodiscard]] virtual std::string file() const { return {}; }
};

/// What a driver may need to know when it is made. The colour manager may be absent when nobody needs one.
struct DriverContext {
    const ColorManager* color = nullptr;
    std::string display, view;  ///< the job's; empty = the config's defaults
    double exposure = 0;        ///< stops, the job's
};

using DisplayDriverFactory =
    std::function<Result<std::unique_ptr<DisplayDriver>>(const ParameterSet&, const DriverContext&)>;

/// "exr" and "tev"; the program adds "png".
Registry<DisplayDriverFactory>& display_driver_registry();

/// A driver by name and parameters. Errors at the set's location: no such driver, a wrong or unknown parameter.
Result<std::unique_ptr<DisplayDriver>> make_display_driver(const std::string& name, const ParameterSet& parameters,
                                                           const DriverContext& context);

/// "png:file=a.png,layer=Nn" as name and parameters, typed by the driver's own table. A value may be quoted with '...'
/// to hold commas. Errors at `where`: no such driver or parameter (with near misses), a value of the wrong type.
using DriverRequest = ObjectRequest;
Result<DriverRequest> parse_driver_request(const std::string& text, const SourceLocation& where);

/// The layers of a frame buffer as drivers see them.
std::vector<DriverLayer> driver_layers(std::span<const ChannelDefinition> channels, ChannelId beauty);

}  // namespace raylex::display
