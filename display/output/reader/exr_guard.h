// An OpenEXR file's header, read by ourselves before the library is let near the file: what kind of file it is, whether
// its attributes end within it, and how much memory its pixels would take.
#pragma once

#include <string>

#include "lpe/result.h"

namespace raylex::display {

/// Errors name the file: no regular file, no OpenEXR file, a header that does not end within the file, uncompressed
/// pixels that the file is too short for, pixels beyond Budget::image_pixels or, for the size of the file, beyond
/// Budget::exr_ratio. What is allowed here may still be damaged further on; the library says so.
Status check_exr_file(const std::string& path);

}  // namespace raylex::display
