// Declarations for the sources of this folder that call Embree. No other file includes this header.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "transport/embree/embree_scene.h"
#include "transport/embree/embree_version.h"

namespace raylex::transport {

inline constexpr unsigned opaque_mask = 1, alpha_mask = 2, any_mask = opaque_mask | alpha_mask;

/// Makes a geometry for quadrics or patches. attach() sets its user data to its ShapeGeometry.
RTCGeometry new_user_geometry(RTCDevice device, unsigned primitives);

/// Returns an error if Embree was built without a feature that raylex needs.
Status check_features(RTCDevice device);

struct EmbreeErrorLog {
    std::mutex mutex;
    std::string message;
};

struct EmbreeScene::Device {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<RTCScene> objects;
    std::vector<RTCGeometry> geometries;  // [shape]; null for empty meshes
    EmbreeErrorLog log;
    std::atomic<std::uint64_t> untraced{0};

    ~Device() {
        for (RTCGeometry g : geometries)
            if (g) rtcReleaseGeometry(g);
        if (scene) rtcReleaseScene(scene);
        for (RTCScene s : objects) rtcReleaseScene(s);
        if (device) rtcReleaseDevice(device);
    }
    RTCScene new_scene() const {
        RTCScene s = rtcNewScene(device);
        rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_MEDIUM);
        return s;
    }
};

}  // namespace raylex::transport
