// Deep OpenEXR files: writing a deep buffer, and flattening a file to compare it with the shallow image.
#pragma once

#include <string>
#include <vector>

#include "display/deep/deep_buffer.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"

namespace raylex::display {

struct DeepStorage {
    ExrCompression compression = ExrCompression::zips;  ///< none, rle or zips: all that deep data may have
    bool half_color = false;                            ///< of light; Z, ZBack, A and everything else stay float
};

/// "zips", "half", "half rle": words in any order. Errors at `where`.
Result<DeepStorage> parse_deep_storage(const std::string& text, const SourceLocation& where);

/// One scanline part with Z, ZBack and A (FLOAT) and, premultiplied, R G B of beauty and NAME.R ... of the others, all
/// paired with A. deepImageState is sorted or tidy as the buffer's options say. Written to a temporary name and
/// renamed. The description's string attributes, chromaticities and matrices go into the header. Values beyond the
/// stored type are counted there as in a flat image, `repaired/NAME`; `repaired` gets these attributes.
Status write_deep_exr(const std::string& path, const DeepBuffer& deep, ChannelId beauty, ImageDescription description,
                      const DeepStorage& storage, std::map<std::string, std::string>* repaired = nullptr);

/// A deep file flattened front to back against a shallow image, pixel by pixel.
struct DeepVerdict {
    std::vector<std::string> layers;  ///< compared, "beauty" among them
    double largest_alpha = 0;         ///< |alpha - shallow alpha|
    double largest_color = 0;         ///< relative to the sum of |colours| + |shallow|
    int alpha_x = 0, alpha_y = 0, color_x = 0, color_y = 0;
    std::size_t samples = 0, most_samples = 0, exceeding = 0;  ///< in all; in one pixel; pixels beyond the bound
    std::size_t clamped = 0;  ///< pixels with a colour at the largest number of its type, in either image
    bool sorted = true;       ///< every pixel's samples are, as the file says
    bool holds = false;
};

/// With n samples c_k, A_k in a pixel and u = 2^-23 (2^-10 for half colours), allowed are
///     alpha   n u_A + u,  u_A = 2^-23,
///     colour  (n u_A + u_c) sum |c_k| + u (|shallow| + sum |c_k|):
/// each A is off by at most its rounding, which adds up along T, and T scales what lies behind. What clamped values can
/// explain is no error. Errors: no deep file, a size unlike the image's, no layer in common.
Result<DeepVerdict> check_deep(const std::string& path, const ExrImage& image);

}  // namespace raylex::display
