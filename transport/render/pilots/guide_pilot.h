// Teaches a guide (paths/guide/guide.h) before the render: rounds of paths over the whole image, each drawn by the
// guide of the rounds before.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/integrators/integrator.h"
#include "transport/paths/guide/guide.h"
#include "transport/paths/guide/guide_summary.h"

namespace raylex::transport {

struct GuideTraining {
    GuideRequest request;
    std::vector<display::ChannelId> channels;  ///< whose light the guide looks for
    int threads = 1;
    std::uint64_t whole = 0;  ///< samples of each pixel of the whole render; 0: unknown
    /// Wall time that the training should take at most; 0: the samples alone count. Then no `whole` is given.
    double seconds = 0;
    std::function<bool()> stopped;  ///< whether the render has to end; called a few times a second
};

struct TrainedGuide {
    std::unique_ptr<const Guide> guide;  ///< null: closures draw all directions
    GuideSummary summary;
    std::uint64_t rays = 0;  ///< traced by the training

    [[nodiscard]] std::string record() const;
    /// Returns the guide of a record(), or nothing if the bytes are none.
    static std::optional<TrainedGuide> from_record(std::string_view bytes);
};

/// Most samples of each pixel that train_guide() takes, a power of 2; 0: it does not train. Beside the paths' own
/// settings, the guide depends on this number alone.
std::uint32_t training_samples(const IntegratorContext& context, const GuideTraining& training);

/// Round 0 measures the means of small tiles and the cost of paths without a guide. Round r takes 2^(r - 1) samples of
/// each pixel and refines the guide. No training sample is part of the image, so the image is unbiased whatever was
/// learned. The guide depends on the scene, the seed, the channels and the samples of its training, and not on threads
/// (Law 3). With GuideMode::automatic, the guide is used only if it is forecast to reduce variance x cost. A bad
/// forecast ends the training early.
TrainedGuide train_guide(const IntegratorContext& context, const GuideTraining& training);

}  // namespace raylex::transport
