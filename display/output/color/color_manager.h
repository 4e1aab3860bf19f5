// The interface to OpenColorIO: the config, scene-linear conversions, and the view transform for previews.
//
// Chromaticities are related to a config's spaces through a space of the config with known primaries: the role
// aces_interchange (or a space named ACES2065-1), else the role cie_xyz_d65_interchange. A config with neither (most of
// version 1) does not define its spaces. Its scene_linear role is then assumed to have Rec. 709 primaries, as in most
// version 1 configs for film and games, and description() mentions this. Whites are adapted by Bradford.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "display/output/image_types.h"
#include "lpe/result.h"

namespace raylex::display {

/// The result of a config's file rules for one image file.
struct FileColor {
    std::string space;        ///< the colour space of the rule
    bool is_data = false;     ///< values are data; convert() does not change them
    bool by_default = false;  ///< only the last rule, which applies to every file, matched
    /// Converts linear RGB triples of the file to linear RGB with the requested primaries, in place. A value that is
    /// not finite becomes 0. Any thread can call it, also after the manager is destroyed.
    std::function<void(std::span<float> rgb)> convert;
};

class ColorManager {
  public:
    /// Opens `config_path`, or else $OCIO, or else the config that ships with raylex.
    static Result<ColorManager> open(const std::string& config_path = {});
    ~ColorManager();
    ColorManager(ColorManager&&) noexcept;
    ColorManager& operator=(ColorManager&&) noexcept;

    [[nodiscard]] std::string description() const;  ///< file and name, for headers and reports
    [[nodiscard]] std::vector<std::string> scene_linear_spaces() const;
    [[nodiscard]] std::vector<std::string> displays() const;
    [[nodiscard]] std::vector<std::string> views(const std::string& display) const;
    [[nodiscard]] std::string default_display() const;
    [[nodiscard]] std::string default_view(const std::string& display) const;

    /// The row-major 3x3 matrix from linear RGB with `from` chromaticities to the named scene-linear space of the
    /// config (a name, alias or role). A result within 1e-5 of the identity becomes the identity, so that equal spaces
    /// change no bit. Errors: no such space (with similar names), a space that is data or not linear.
    [[nodiscard]] Result<std::array<std::array<double, 3>, 3>> matrix_to(const std::string& space,
                                                                         const Chromaticities& from) const;
    /// The chromaticities of a named scene-linear space. A matrix determines them only up to the adaptation of the
    /// white. Published sets (Rec. 709, Rec. 2020, P3-D65, Adobe RGB, AP0, AP1) are recognised; others are relative to
    /// D65.
    [[nodiscard]] Result<Chromaticities> chromaticities(const std::string& space) const;

    /// The colour of a file by the first file rule that matches its path. "extension" in a rule is a glob, not a
    /// regular expression: warnings() lists rules that can never match. Errors: a space that the config cannot convert
    /// from.
    [[nodiscard]] Result<FileColor> file_color(const std::string& path, const Chromaticities& to) const;
    /// Suspicious parts of the config that are not errors.
    [[nodiscard]] std::vector<std::string> warnings() const;

    /// Converts linear RGB triples with the given primaries through a display and view to 8-bit RGB. A non-finite
    /// component counts as 0. An empty display or view means the default. A view of data (Raw) shows the values
    /// unchanged.
    [[nodiscard]] Result<std::vector<unsigned char>> to_display(std::span<const float> rgb,
                                                                const Chromaticities& primaries,
                                                                const std::string& display,
                                                                const std::string& view) const;

  private:
    struct Config;
    explicit ColorManager(std::unique_ptr<Config> config);
    std::unique_ptr<Config> config_;
};

/// Writes an 8-bit RGB PNG with rows from the top, to a temporary file that is then renamed.
Status write_png(const std::string& path, int width, int height, std::span<const unsigned char> rgb);
/// Encodes an 8-bit RGB PNG as bytes, for pages that embed images.
Result<std::vector<unsigned char>> encode_png(int width, int height, std::span<const unsigned char> rgb);

}  // namespace raylex::display
