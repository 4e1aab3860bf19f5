// Declarations that embree_scene.cpp, embree_trace.cpp and embree_user_shapes.cpp share, and no other file includes.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <embree3/rtcore.h>

#include "transport/embree/embree_scene.h"

namespace raylex::transport {

inline constexpr unsigned opaque_mask = 1, alpha_mask = 2, any_mask = opaque_mask | alpha_mask;

/// The user data of Embree's callbacks for a user geometry.
struct UserShape {
    const ShapeGeometry* shape = nullptr;
    unsigned mask = opaque_mask;
};

/// Makes a geometry for quadrics or patches. attach() sets its user data to a UserShape.
RTCGeometry new_user_geometry(RTCDevice device, unsigned primitives);

struct EmbreeErrorLog {
    std::mutex mutex;
    std::string message;
};

struct EmbreeScene::Device {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<RTCScene> objects;
    std::vector<std::unique_ptr<UserShape>> users;
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
