// OpenColorIO behind one file: the config, scene-linear conversions, and the view transform for previews.
//
// How chromaticities meet a config's spaces: through the space of the config whose primaries are known. That is the
// role aces_interchange (or a space called ACES2065-1), else the role cie_xyz_d65_interchange. A config with neither
// (most of version 1) says nowhere what its spaces mean: its scene_linear role is then taken to have Rec. 709
// primaries, as version 1 configs for film and games mostly do, and description() says so. Whites are adapted by
// Bradford.
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

/// What a config's file rules say of one image file.
struct FileColor {
    std::string space;        ///< the colour space they name
    bool is_data = false;     ///< values mean themselves; convert() leaves them
    bool by_default = false;  ///< no rule but the last, which every file falls to
    /// Linear RGB triples as stored in the file to linear RGB with the primaries asked for, in place. A value that is
    /// not finite becomes 0. Callable from any thread, also after the manager is gone.
    std::function<void(std::span<float> rgb)> convert;
};

class ColorManager {
  public:
    /// `config_path`, else $OCIO, else the config that ships with raylex.
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

    /// Row-major 3x3 from linear RGB with `from` chromaticities to the named scene-linear space of the config (a name,
    /// alias or role). A result within 1e-5 of the identity is the identity, so that equal spaces change no bit.
    /// Errors: no such space (with near misses), a space that is data or not linear.
    [[nodiscard]] Result<std::array<std::array<double, 3>, 3>> matrix_to(const std::string& space,
                                                                         const Chromaticities& from) const;
    /// Chromaticities of a named scene-linear space. A matrix only fixes them up to the adaptation of the white:
    /// published sets (Rec. 709, Rec. 2020, P3-D65, Adobe RGB, AP0, AP1) are recognised, anything else is given
    /// relative to D65.
    [[nodiscard]] Result<Chromaticities> chromaticities(const std::string& space) const;

    /// The first file rule that fits the path decides. "extension" in a rule is a glob, not a regular expression:
    /// warnings() names rules that can never fit. Errors: a space that the config cannot convert from.
    [[nodiscard]] Result<FileColor> file_color(const std::string& path, const Chromaticities& to) const;
    /// What looks wrong in the config without being an error.
    [[nodiscard]] std::vector<std::string> warnings() const;

    /// Linear RGB triples with the given primaries through a display and view to 8-bit RGB. A non-finite component
    /// counts as 0. Empty display or view: the defaults. A view of data (Raw) shows the values as they are.
    [[nodiscard]] Result<std::vector<unsigned char>> to_display(std::span<const float> rgb,
                                                                const Chromaticities& primaries,
                                                                const std::string& display,
                                                                const std::string& view) const;

  private:
    struct Config;
    explicit ColorManager(std::unique_ptr<Config> config);
    std::unique_ptr<Config> config_;
};

/// 8-bit RGB PNG, rows from the top, written to a temporary name and renamed.
Status write_png(const std::string& path, int width, int height, std::span<const unsigned char> rgb);
/// The same as bytes, for pages that embed images.
Result<std::vector<unsigned char>> encode_png(int width, int height, std::span<const unsigned char> rgb);

}  // namespace raylex::display
