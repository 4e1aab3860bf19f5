// Settings resolved against a scene: what a render is to do, or why it cannot. Private to render.cpp.
#pragma once

#include "transport/integrators/integrator.h"
#include "transport/render/render.h"
#include "transport/render/render_loop.h"

namespace raylex::transport {

struct ResolvedRender {
    RenderJob job;
    ChosenIntegrator chosen;  ///< job.integrator points into it
    std::string sampler;      ///< name
};

/// Everything that can be refused before a ray is traced, except what the integrator finds when it prepares.
Result<ResolvedRender> resolve_render(const BuiltScene& scene, const RenderSettings& settings,
                                      std::vector<Error>& warnings);

}  // namespace raylex::transport
