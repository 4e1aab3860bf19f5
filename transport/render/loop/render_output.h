// Converts a finished loop to the caller's result. Private to transport/render.
#pragma once

#include "transport/render/loop/render_loop.h"

namespace raylex::transport {

/// Moves the image out of `target`.
RenderOutput output_of(const ResolvedJob& job, RenderTarget target, FinishedLoop finished);

}  // namespace raylex::transport
