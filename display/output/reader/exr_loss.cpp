#include "display/output/reader/exr_loss.h"

#include <cmath>
#include <string_view>

#include <ImfCompression.h>
#include <ImfFloatAttribute.h>

namespace raylex::display {

PlaneLoss plane_loss(const Imf::Header& header, const char* channel, Imf::PixelType type) {
    switch (header.compression()) {
        case Imf::PXR24_COMPRESSION:
            return type == Imf::FLOAT ? PlaneLoss::pxr24 : PlaneLoss::none;
        case Imf::B44_COMPRESSION:
        case Imf::B44A_COMPRESSION:
            return type == Imf::HALF ? PlaneLoss::b44 : PlaneLoss::none;
        case Imf::DWAA_COMPRESSION:
        case Imf::DWAB_COMPRESSION: {
            // The last part of the channel's name decides, in either case, because old files were written so; other
            // channels are packed without loss.
            std::string_view name(channel);
            name.remove_prefix(name.rfind('.') + 1);
            for (const char* lossy :
                 {"R", "G", "B", "Y", "RY", "BY", "r", "g", "b", "y", "ry", "by", "red", "green", "blue"})
                if (name == lossy && type != Imf::UINT) return PlaneLoss::dwa;
            return PlaneLoss::none;
        }
        default:
            return PlaneLoss::none;
    }
}

float dwa_level(const Imf::Header& header) {
    const auto* level = header.findTypedAttribute<Imf::FloatAttribute>("dwaCompressionLevel");
    return level != nullptr && std::isfinite(level->value()) && level->value() >= 0 ? level->value() : 45.0f;
}

}  // namespace raylex::display
