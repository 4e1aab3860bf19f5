// Teaches a guide (paths/guide/guide.h) before the render: rounds of paths over the whole image, each drawn by the
// guide of the rounds before.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <span>

#include "transport/integrators/integrator.h"
#include "transport/paths/guide/guide.h"
#include "transport/paths/guide/guide_summary.h"

namespace raylex::transport {

struct GuideTraining {
    GuideRequest request;
    std::span<const display::ChannelId> channels;  ///< whose light the guide looks for
    int threads = 1;
    std::function<bool()> stopped;  ///< whether the render has to end; called a few times a second
};

struct TrainedGuide {
    std::unique_ptr<const Guide> guide;  ///< null: closures draw all directions
    GuideSummary summary;
    std::uint64_t rays = 0;  ///< traced by the training
};

/// Round 0 measures the means of small tiles and the cost of paths without a guide. Round r takes 2^(r - 1) samples of
/// each pixel and refines the guide. No training sample is part of the image, so the image is unbiased whatever was
/// learned. The guide depends on the scene, the seed, the channels and the samples of its training, and neither on
/// threads nor on the samples of the render (Law 3). With GuideMode::automatic, it is used only if the forecast of
/// variance x cost says that it pays, and the training ends early where it does not.
TrainedGuide train_guide(const IntegratorContext& context, const GuideTraining& training);

}  // namespace raylex::transport
