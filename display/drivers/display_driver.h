// Display drivers: destinations of an image. Files, viewers and plugins implement this interface; a render can have any
// number of them at once.
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

/// One layer for a driver. Beauty comes first (with alpha as its last plane), then the channels in order.
struct DriverLayer {
    std::string name;  ///< "" for beauty
    ChannelId channel = invalid_channel;
    ChannelType type = ChannelType::rgb;
    std::vector<std::string> planes;  ///< names as in an OpenEXR file: R G B A, diffuse.R ..., Z
    bool alpha = false;
};

/// The properties of the image that are known before the first sample.
struct DriverImage {
    std::string title;  ///< file name of the output; viewers can use it as the image's name
    int width = 0, height = 0;
    std::vector<DriverLayer> layers;
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
    Chromaticities chromaticities;
    std::vector<PartitionDeclaration> partitions;
};

/// The pixels of one layer in a region, in row order with interleaved planes: scene-linear, never NaN, infinite only
/// where a channel's miss value is.
struct DriverRegion {
    std::size_t layer = 0;  ///< index in DriverImage::layers
    PixelRegion region;
    std::span<const float> values;
};

/// The finished image; `description.complete` is true if it contains all samples.
struct FinishedImage {
    const PixelImage& frame_buffer;
    ChannelId beauty = invalid_channel;
    const ImageDescription& description;
};

/// One thread calls open(), then region() and progress() during the render (region() only for live drivers), then
/// close(). No call may wait for anything outside the program, except close() for a short time.
class DisplayDriver {
  public:
    virtual ~DisplayDriver() = default;
    /// An Error ends the render before it starts: a file that cannot be written, a layer that does not exist.
    virtual Status open(const DriverImage& image) = 0;
    /// Returns whether the driver needs region(): for the growing image, and for the whole image once more before
    /// close().
    [[nodiscard]] virtual bool is_live() const { return false; }
    /// Returns false if the driver has no room now; the region is sent again later with newer values.
    virtual bool region(const DriverRegion& /*region*/) { return true; }
    virtual void progress(double /*fraction*/) {}
    virtual Status close(const FinishedImage& image) = 0;
    /// A problem that does not affect the image; empty if there is none. It is queried repeatedly and shown once.
    [[nodiscard]] virtual std::string warning() const { return {}; }
    /// The file that the driver writes, for the summary; empty for none.
    [[nodiscard]] virtual std::string file() const { return {}; }
};

/// Inputs for making a driver. The colour manager can be absent if no driver needs one.
struct DriverContext {
    const ColorManager* color = nullptr;
    std::string display, view;  ///< from the job; empty = the config's defaults
    double exposure = 0;        ///< in stops, from the job
};

using DisplayDriverFactory =
    std::function<Result<std::unique_ptr<DisplayDriver>>(const ParameterSet&, const DriverContext&)>;

/// "exr" and "tev"; the program adds "png".
Registry<DisplayDriverFactory>& display_driver_registry();

/// Makes a driver from its name and parameters. Errors, at the set's location: no such driver, a wrong or unknown
/// parameter.
Result<std::unique_ptr<DisplayDriver>> make_display_driver(const std::string& name, const ParameterSet& parameters,
                                                           const DriverContext& context);

/// Parses "png:file=a.png,layer=Nn" into name and parameters; the driver's table gives their types. '...' around a
/// value permits commas in it. Errors, at `where`: no such driver or parameter (with similar names), a value of the
/// wrong type.
using DriverRequest = ObjectRequest;
Result<DriverRequest> parse_driver_request(const std::string& text, const SourceLocation& where);

/// The layers of a frame buffer in the form that drivers get.
std::vector<DriverLayer> driver_layers(std::span<const ChannelDefinition> channels, ChannelId beauty);

}  // namespace raylex::display
