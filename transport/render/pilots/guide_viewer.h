// Looks from the pixels of an image at what its guide learned.
#pragma once

#include <atomic>
#include <memory>

#include "transport/integrators/integrator.h"
#include "transport/paths/guide/guide.h"
#include "transport/paths/guide/guide_view.h"

namespace raylex::transport {

/// Follows a path through each point of a grid of at most 16,384 pixels, with one thread. No sample is part of the
/// image. `context`: of the render, which uses `guide`. Once `*stop` (may be null) is set, paths end early.
std::shared_ptr<const GuideView> view_guide(const IntegratorContext& context, const GuideRequest& request,
                                            const Guide& guide, const std::atomic<bool>* stop);

}  // namespace raylex::transport
