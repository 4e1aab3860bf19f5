// Everything that differs between Embree 3.13 and Embree 4. RAYLEX_EMBREE is the major version that CMake found
// (transport/cmake/raylexEmbree.cmake).
#pragma once

#include <span>

#if RAYLEX_EMBREE == 3
#include <embree3/rtcore.h>
#elif RAYLEX_EMBREE == 4
#include <embree4/rtcore.h>
#else
#error "expected RAYLEX_EMBREE to be 3 or 4"
#endif

namespace raylex::transport {

#if RAYLEX_EMBREE == 3

/// The arguments of Embree's calls. Each batch of rays makes its own.
class RayQuery {
  public:
    RayQuery() { rtcInitIntersectContext(&context_); }
    void closest(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &context_, &ray); }
    void shadow(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &context_, &ray); }
    /// Traces all shadow rays as one stream, which gives the results of single rays. Returns false if Embree has no
    /// streams.
    bool shadow_stream(RTCScene scene, std::span<RTCRay> rays) {
        rtcOccluded1M(scene, &context_, rays.data(), static_cast<unsigned>(rays.size()), sizeof(RTCRay));
        return true;
    }

  private:
    RTCIntersectContext context_;
};

#else

/// The arguments of Embree's calls. Each batch of rays makes its own.
class RayQuery {
  public:
    RayQuery() {
        rtcInitRayQueryContext(&context_);
        rtcInitIntersectArguments(&closest_);
        rtcInitOccludedArguments(&shadow_);
        closest_.context = shadow_.context = &context_;
    }
    RayQuery(const RayQuery&) = delete;
    RayQuery& operator=(const RayQuery&) = delete;
    void closest(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, &closest_); }
    void shadow(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, &shadow_); }
    static bool shadow_stream(RTCScene, std::span<RTCRay>) { return false; }

  private:
    RTCRayQueryContext context_;
    RTCIntersectArguments closest_;
    RTCOccludedArguments shadow_;
};

#endif

}  // namespace raylex::transport
