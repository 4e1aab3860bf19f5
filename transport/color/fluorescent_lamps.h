// The fluorescent lamps of CIE 15:2004, table T.6: illuminants FL1 to FL12, which pbrt-v4 calls stdillum-F1 to -F12.
#pragma once

#include "transport/color/spectral_data.h"

namespace raylex::transport {

inline constexpr int fluorescent_lamp_count = 12;
/// Relative power of lamp `number` (1 to 12): the 5 nm table, interpolated linearly.
[[nodiscard]] VisibleSpectrum fluorescent_lamp(int number);

}  // namespace raylex::transport
