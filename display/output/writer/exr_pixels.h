// From a frame buffer's channel to the values of a part as they will stand in the file.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/output/splits/split_sum.h"
#include "display/output/writer/exr_layout.h"

namespace raylex::display {

/// Values that a file cannot hold, and what became of them.
struct Repairs {
    std::size_t not_a_number = 0, out_of_range = 0;

    /// `value` rounded to the stored type, NaN to 0, numbers out of range to the largest; infinity stays when it is the
    /// channel's miss value.
    float to_stored(double value, float miss, StoredType type);
};

/// One part's pixels: plane after plane, in the part's order of planes.
struct PartPixels {
    std::vector<std::vector<char>> planes;   ///< bytes as the file's type wants them, row-major
    std::vector<std::vector<float>> judged;  ///< the same values as float, where a split needs them: 3 or 1 planes
};

/// In whole rows [rows.y0, rows.y1).
[[nodiscard]] PartPixels part_pixels(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows,
                                     bool judged);

/// Whether a part may hold values that its file cannot.
[[nodiscard]] bool may_need_repair(const PixelImage& frame_buffer, const PlannedPart& part);
/// Adds what these rows of such a part will need.
void note_repairs(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows, Repairs& repairs);
/// The text of a `repaired/NAME` attribute, empty when nothing had to be repaired.
[[nodiscard]] std::string repairs_text(const Repairs& repairs, StoredType type);

}  // namespace raylex::display
