// Deep OpenEXR files: writes a deep buffer, and flattens a file for comparison with the shallow image.
#pragma once

#include <string>
#include <vector>

#include "display/deep/deep_buffer.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

struct DeepStorage {
    ExrCompression compression = ExrCompression::zips;  ///< none, rle or zips; OpenEXR supports no others for deep data
    bool half_color = false;                            ///< store light as half; Z, ZBack, A and everything else stay
                                                        ///< float
};

/// Parses "zips", "half", "half rle": words in any order. Errors are at `where`.
Result<DeepStorage> parse_deep_storage(const std::string& text, const SourceLocation& where);

/// Writes one scanline part with Z, ZBack and A (FLOAT) and, premultiplied, R G B of beauty and NAME.R ... of the other
/// channels, all with the same A. deepImageState is sorted or tidy, according to the buffer's options. The file gets a
/// temporary name and is then renamed. The header contains the description's string attributes, chromaticities and
/// matrices. Values beyond the stored type are counted in `repaired/NAME`, as in a flat image; `repaired` gets these
/// attributes.
Status write_deep_exr(const std::string& path, const DeepBuffer& deep, ChannelId beauty, ImageDescription description,
                      const DeepStorage& storage, std::map<std::string, std::string>* repaired = nullptr);

/// The comparison of a deep file, flattened front to back, with a shallow image, pixel by pixel.
struct DeepCheck {
    std::vector<std::string> layers;  ///< compared layers, including "beauty"
    double largest_alpha = 0;         ///< |alpha - shallow alpha|
    double largest_color = 0;         ///< relative to the sum of |colours| + |shallow|
    int alpha_x = 0, alpha_y = 0, color_x = 0, color_y = 0;
    std::size_t samples = 0, most_samples = 0, exceeding = 0;  ///< in total; in one pixel; pixels beyond the bound
    std::size_t clamped = 0;  ///< pixels with a colour at the largest number of its type, in one of the images
    bool sorted = true;       ///< every pixel's samples are sorted, as the file declares
    bool holds = false;
};

/// Bounds for a pixel with n samples c_k, A_k and u = 2^-23 (2^-10 for half colours):
///     alpha   n u_A + u,  u_A = 2^-23,
///     colour  (n u_A + u_c) sum |c_k| + u (|shallow| + sum |c_k|):
/// each A has a rounding error, these add up in T, and T scales everything behind. Deviations that clamped values can
/// explain are not errors. Errors: not a deep file, a size different from the image's, no common layer.
Result<DeepCheck> check_deep(const std::string& path, const ExrImage& image);

}  // namespace raylex::display
