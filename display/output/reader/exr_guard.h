// Parses the header of an OpenEXR file before the library opens it: the kind of file, whether its attributes end inside
// it, and the memory that its pixels need.
#pragma once

#include <string>

#include "lpe/result.h"

namespace raylex::display {

/// Errors, which name the file: not a regular file, not an OpenEXR file, a header that does not end inside the file, a
/// file too short for its uncompressed pixels, more pixels than Budget::image_pixels, or too many pixels for the size
/// of the file (Budget::exr_ratio). A file that passes can still be damaged further on; the library reports that.
Status check_exr_file(const std::string& path);

}  // namespace raylex::display
