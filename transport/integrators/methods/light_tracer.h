// `lighttracer`: paths from the lights; each vertex is connected to the camera and splatted where the camera sees it.
//
// The measurement of a pixel (Veach 1997, equation 8.5) is estimated from the other end. A light and a ray leaving it
// are drawn by emitted power. Each vertex is connected to the pinhole or lens: the path's power times the scattering
// towards the camera, cos / distance^2 and the camera's raster area per solid angle goes to the raster position where
// the camera sees the point. A camera sample is one light path: n samples a pixel are n x width x height light paths.
//
// The string of a splat is read from the camera: C, the event of the connected vertex, the events before it back to the
// light, the light. Vertices keep what each lobe scattered, so channels take exact shares as with `path` (Law 5).
//
// Emitters that the camera sees directly are found by camera rays, with AOVs, alpha and mattes. What the camera sees by
// a mirror or through smooth glass is not found: no light path can be connected there, and the render warns. The
// prefixes nothruput, unoccluded and shadows are refused.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// The registry's entry: parameters maxdepth, roulette, rrthreshold.
Registry<IntegratorFactory>::Entry light_tracer_entry();

}  // namespace raylex::transport
