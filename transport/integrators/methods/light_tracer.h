// `lighttracer`: paths from the lights; each vertex is connected to the camera and splatted where the camera sees it.
//
// The measurement of a pixel, integral of kernel x radiance over the raster, is estimated from the other end (Veach
// 1997, section 4.A and chapter 8). A light and a ray leaving it are drawn by emitted power. At each vertex the path's
// power times the scattering towards the camera, cos / distance^2 and the camera's raster area per solid angle goes to
// the raster position where the camera sees the point. Pinholes and thin lenses connect. A camera sample is one light
// path, so that n samples a pixel are n x width x height light paths.
//
// Path strings. A splat's string is read as the camera would have met it: C, the event of the connected vertex, those
// of the vertices before it back to the light, the light. Each vertex keeps its lobes and what each of them scattered,
// so channels take exact shares as with `path` (Law 5).
//
// Not found from the light: emitters that the camera sees directly are traced from the camera (C L, C B, cutouts
// passed). What the camera sees by a mirror or through smooth glass (C, a singular event, anything) is not found at
// all, because no light path can be connected there. The render warns where a scene has such surfaces. Light that media
// emit is found where the camera sees it directly (C O). The prefixes nothruput, unoccluded and shadows are refused.
// AOVs, alpha and mattes come from the camera rays as with `path`.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// The registry's entry: parameters maxdepth, roulette, rrthreshold.
Registry<IntegratorFactory>::Entry light_tracer_entry();

}  // namespace raylex::transport
