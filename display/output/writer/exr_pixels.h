// Converts a channel of a frame buffer to the values of a part as the file stores them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/output/splits/split_sum.h"
#include "display/output/writer/exr_layout.h"

namespace raylex::display {

/// Counts the values that a file cannot store, by replacement.
struct Repairs {
    std::size_t not_a_number = 0, out_of_range = 0;

    /// Rounds `value` to the stored type: NaN becomes 0, numbers out of range become the largest; infinity stays if it
    /// is the channel's miss value.
    float to_stored(double value, float miss, StoredType type);
};

/// The pixels of one part: plane after plane, in the part's order.
struct PartPixels {
    std::vector<std::vector<char>> planes;    ///< bytes of the file's type, row-major
    std::vector<std::vector<float>> checked;  ///< the values as float, if a split needs them: 3 planes or 1
};

/// The pixels of a part in whole rows [rows.y0, rows.y1).
[[nodiscard]] PartPixels part_pixels(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows,
                                     bool checked);

/// Returns whether a part can have values that its file cannot store.
[[nodiscard]] bool may_need_repair(const PixelImage& frame_buffer, const PlannedPart& part);
/// Adds the repairs that these rows of such a part need.
void note_repairs(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows, Repairs& repairs);
/// The text of a `repaired/NAME` attribute, empty if there were no repairs.
[[nodiscard]] std::string repairs_text(const Repairs& repairs, StoredType type);

}  // namespace raylex::display
