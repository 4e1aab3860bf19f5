// A layer of two images side by side: every metric by its name, and its error pixel by pixel.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "display/output/metrics/image_metrics.h"
#include "display/output/reader/exr_reader.h"
#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::display {

/// A metric of single values or one of whole images: exactly one of the two is set.
struct AnyMetric {
    std::string name, formula;
    std::optional<ErrorMetric> of_values;
    std::optional<ImageMetric> of_image;
};
/// Those of error_metrics(), then those of image_metrics().
std::vector<AnyMetric> all_metrics();
std::optional<AnyMetric> find_metric(std::string_view name);
/// The same, or an Error at `where` with the near miss; `beside` are further names that one may say there.
Result<AnyMetric> require_metric(const std::string& name, const SourceLocation& where,
                                 const std::vector<std::string>& beside = {});

/// [3 * width * height] R G B of these primaries, as metrics of whole images take them.
LinearImage in_rec709(int width, int height, std::vector<double> rgb, const Chromaticities& from);

/// The layer in the reference's primaries; `component` is as display::compare has it.
class LayerPair {
  public:
    /// Errors: no such layer in either image, sizes that differ, planes that are neither R G B nor X Y Z nor a single
    /// one.
    static Result<LayerPair> make(const ExrImage& image, const ExrImage& reference, const std::string& layer);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }

    /// Errors: an unknown component; a metric without a value, as is the ratio to a mean of 0. Metrics of whole images
    /// take all components, of colours or of a single plane, all values finite; else they are errors.
    [[nodiscard]] Result<double> value(const AnyMetric& metric, char component) const;

    /// [height * width] the metric's term, its mean over the components: the mean of the map is the metric, but for
    /// rmse (each pixel its own root), trimmed_relmse_mean (nothing is trimmed) and ssim (1 - ssim). `value` is the
    /// metric, as value() has it. Errors: those of value(); a metric that is no mean over pixels.
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
    std::vector<double> image_, reference_;  // three values a pixel
};

/// A map of errors as 8-bit RGB, its lightness rising with the error: black 0, over blue, violet and red to pale yellow
/// for `most` and above. Cyan marks what is not finite.
std::vector<unsigned char> error_colors(const std::vector<double>& map, double most);
/// These colours as PNG.
Status write_error_png(const std::string& path, const std::vector<double>& map, int width, int height, double most);
/// The same as OpenEXR: one float channel `error`, with these string attributes.
Status write_error_exr(const std::string& path, const std::vector<double>& map, int width, int height,
                       const std::map<std::string, std::string>& attributes);

}  // namespace raylex::display
