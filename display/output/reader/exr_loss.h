// The loss that a part's compression causes in its planes, according to the header of the file.
#pragma once

#include <ImfHeader.h>
#include <ImfPixelType.h>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

[[nodiscard]] PlaneLoss plane_loss(const Imf::Header& header, const char* channel, Imf::PixelType type);
/// The compression level of DWA; 45 (the library's default) if the header does not contain it.
[[nodiscard]] float dwa_level(const Imf::Header& header);

}  // namespace raylex::display
