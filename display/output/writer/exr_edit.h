// Copies an OpenEXR file of any writer and changes some of its channels. All else keeps its bits: names, types, ids,
// deep parts, attributes, compression.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "display/output/image_types.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// A channel of a flat part, by its full name.
struct ExrChannel {
    int part = 0;
    std::string name;
    auto operator<=>(const ExrChannel&) const = default;
};

struct ExrEdit {
    std::vector<ExrChannel> planes;  ///< the channels that `change` gets, in this order
    std::set<ExrChannel> changed;    ///< those of them that are written back
    /// Stores changed channels as float. Parts that are packed again get a lossless compression.
    bool changed_to_float = false;
    std::set<ExrChannel> removed;  ///< channels that the copy lacks; a part without channels is left out
    std::vector<DataPart> added;   ///< new parts, or channels of the only part of a file
    /// Changes a band of rows, plane by plane. Called from the top to the bottom of the data window, with the pixels of
    /// the band, counted from the upper left corner of the display window. A half beyond its range becomes infinite.
    std::function<void(const PixelRegion& band, std::span<std::vector<float>> planes)> change;
    std::map<std::string, std::string> attributes;            ///< added to the first part, or replaced there
    std::function<bool(const std::string&)> drops_attribute;  ///< whether the copy lacks an attribute
};

/// Writes the copy to a temporary file and renames it. Parts with changed or removed channels are packed again, with
/// their compression, in scan lines. All other parts are copied without unpacking. Errors: a damaged file; subsampled
/// channels, or different data windows, in the parts that are read or packed again.
Status edit_exr(const std::string& from, const std::string& to, const ExrEdit& edit);

}  // namespace raylex::display
