// From a finished loop to what the caller gets. Private to transport/render.
#pragma once

#include "transport/render/loop/render_loop.h"

namespace raylex::transport {

/// Takes the image out of `target`.
RenderOutput output_of(const ResolvedJob& job, RenderTarget target, FinishedLoop finished);

}  // namespace raylex::transport
