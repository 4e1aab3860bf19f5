// Compares a layer of two images: every metric by name, and its error per pixel.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "display/output/metrics/image_metrics.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::display {

/// A metric of single values, or of whole images: exactly one of the two is set.
struct AnyMetric {
    std::string name, formula;
    std::optional<ErrorMetric> of_values;
    std::optional<ImageMetric> of_image;
};
/// All of error_metrics(), followed by image_metrics().
std::vector<AnyMetric> all_metrics();
std::optional<AnyMetric> find_metric(std::string_view name);
/// Finds a metric; an Error at `where` suggests a similar name. `beside` are further names that are valid there.
Result<AnyMetric> require_metric(const std::string& name, const SourceLocation& where,
                                 const std::vector<std::string>& beside = {});

/// [3 * width * height] R G B, converted from these primaries to Rec. 709, as input of metrics of whole images.
LinearImage in_rec709(int width, int height, std::vector<double> rgb, const Chromaticities& from);

/// A layer of two images in the reference's primaries. `component` is R, G, B, Y or A.
class LayerPair {
  public:
    /// Prepares the pair. Errors: no such layer in one of the images, different sizes, planes that are neither R G B
    /// nor X Y Z nor a single one.
    static Result<LayerPair> make(const ExrImage& image, const ExrImage& reference, const std::string& layer);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }

    /// The value of a metric. Errors: an unknown component; a metric without a value, such as the ratio to a mean of 0.
    /// Metrics of whole images need all components of a colour, or a single plane, with finite values.
    [[nodiscard]] Result<double> value(const AnyMetric& metric, char component) const;

    /// [height * width] The term of the metric, averaged over the components. The mean of this map is the metric,
    /// except for rmse (each pixel has its own root), trimmed_relmse_mean (nothing is trimmed) and ssim (1 - ssim).
    /// `value` is the metric, as in value(). Errors: those of value(); a metric that is not a mean over pixels.
    [[nodiscard]] Result<ImageErrors> errors(const AnyMetric& metric, char component) const;

  private:
    struct Values {
        std::vector<double> image, reference;
        std::size_t per_pixel = 1;
    };
    [[nodiscard]] Result<Values> values_of(char component) const;
    [[nodiscard]] Result<ImageErrors> look(const AnyMetric& metric, char component) const;
    [[nodiscard]] std::optional<Error> not_finite(const std::string& metric, const Values& values,
                                                  bool equal_allowed) const;

    std::string layer_, image_path_, reference_path_;
    int width_ = 0, height_ = 0;
    bool color_ = false, single_ = false;
    Chromaticities primaries_;
    std::array<double, 3> luminance_{};
    std::vector<double> image_, reference_;  // three values per pixel
};

/// A map of errors as 8-bit RGB. Lightness rises with the error: black for 0, over blue, violet and red to pale yellow
/// for `most` and above. Cyan marks values that are not finite.
std::vector<unsigned char> error_colors(const std::vector<double>& map, double most);
/// Writes error_colors() as PNG.
Status write_error_png(const std::string& path, const std::vector<double>& map, int width, int height, double most);
/// Writes the map as OpenEXR: one float channel `error`, with these string attributes.
Status write_error_exr(const std::string& path, const std::vector<double>& map, int width, int height,
                       const std::map<std::string, std::string>& attributes);

/// Writes the light of Rebuild::light as two layers without negative values: sum + unassigned - counted_twice is what
/// is split, up to what the check allows. The result must be of an image of this size.
Status write_unassigned_exr(const std::string& path, const SplitResult& result, const ExrImage& image);

}  // namespace raylex::display
