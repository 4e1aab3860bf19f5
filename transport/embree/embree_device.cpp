#include "transport/embree/embree_device.h"

namespace raylex::transport {

Status check_features(RTCDevice device) {
    const auto has = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property) != 0; };
    const char* lacking = !has(RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED)            ? "EMBREE_RAY_MASK=ON"
                          : !has(RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED) ? "EMBREE_GEOMETRY_TRIANGLE=ON"
                          : !has(RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED)    ? "EMBREE_GEOMETRY_CURVE=ON"
                          : !has(RTC_DEVICE_PROPERTY_USER_GEOMETRY_SUPPORTED)     ? "EMBREE_GEOMETRY_USER=ON"
                          : has(RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED)     ? "EMBREE_BACKFACE_CULLING=OFF"
                                                                                  : nullptr;
    if (!lacking) return success();
    const std::string version = std::to_string(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION));
    return error_at({}, "the loaded Embree (version " + version + ") cannot be used; expected one built with " +
                            lacking + ", like Debian's libembree");
}

}  // namespace raylex::transport
