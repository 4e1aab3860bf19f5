// What the compression of a part costs its planes, as the file's header tells.
#pragma once

#include <ImfHeader.h>
#include <ImfPixelType.h>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

[[nodiscard]] PlaneLoss plane_loss(const Imf::Header& header, const char* channel, Imf::PixelType type);
/// The level that DWA was told, 45 (the library's default) where the header does not keep it.
[[nodiscard]] float dwa_level(const Imf::Header& header);

}  // namespace raylex::display
