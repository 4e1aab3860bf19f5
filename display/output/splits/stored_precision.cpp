#include "display/output/splits/stored_precision.h"

#include <cmath>
#include <cstdlib>

#include "display/services/elementary.h"

namespace raylex::display {

namespace {

double to_dwa(double x) {
    return x <= 1 ? elementary::pow(x, 1 / 2.2) : 1 + elementary::log(x) / 2.2;
}
double from_dwa(double y) {
    return y <= 1 ? elementary::pow(y, 2.2) : elementary::exp(2.2 * (y - 1));
}

}  // namespace

StoredPrecision precision_of(StoredType type) {
    if (type == StoredType::half_float) return {0x1p-10, 0x1p-24, 0};
    return {0x1p-23, 0x1p-149, 0};
}

double light_magnitude_of(const std::map<std::string, std::string>& attributes) {
    const auto found = attributes.find(light_magnitude);
    const double magnitude = found == attributes.end() ? 0 : std::strtod(found->second.c_str(), nullptr);
    return std::isfinite(magnitude) && magnitude > 0 ? magnitude : 0;
}

double error_of_clamped(double sum, double whole, bool sum_is_clamped, bool whole_is_clamped) {
    const bool explained = std::abs(sum) < std::abs(whole) ? sum_is_clamped : whole_is_clamped;
    return explained ? 0 : std::abs(sum - whole);
}

StoredPrecision precision_of(const ImagePlane& plane) {
    StoredPrecision precision = precision_of(plane.stored);
    if (plane.loss == PlaneLoss::pxr24) precision = {0x1p-15, 0x1p-141, 0};
    if (plane.loss == PlaneLoss::dwa) {
        // DWA converts a float to a half before the transform.
        precision = precision_of(StoredType::half_float);
        precision.dwa = dwa_move(static_cast<double>(plane.dwa_level));
    }
    return precision;
}

double dwa_move(double level) {
    return 0.006 + 0.014 * level / 45;
}

double dwa_change(double value, double distance) {
    // The inverse of the scale is convex, so the outward step gives the larger change.
    const double magnitude = std::abs(value);
    return from_dwa(to_dwa(magnitude) + distance) - magnitude;
}

}  // namespace raylex::display
