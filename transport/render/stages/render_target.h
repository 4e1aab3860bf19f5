// The third stage: the outputs of samples, after the caller has received the plan and memory is allocated. Private to
// transport/render.
#pragma once

#include <memory>
#include <vector>

#include "transport/render/stages/prepared_job.h"

namespace raylex::transport {

/// Returns the plan that the caller receives before the first ray. Its memory is that of the whole image.
RenderPlan plan_of(const ResolvedJob& job);
/// The layout of the image, or of the job's current bucket.
display::FrameBufferLayout layout_of(const ResolvedJob& job);

class RenderTarget {
  public:
    /// Allocates the outputs of the image, or of the job's current bucket, in addition to the caller's sinks. Returns
    /// an Error if memory does not suffice.
    static Result<RenderTarget> allocate(const PreparedJob& prepared, std::vector<display::SampleSink*> sinks);

    /// Whether some sink keeps raw samples, as deep images do: those cannot be saved or undone.
    [[nodiscard]] bool has_sinks_of_others() const { return sinks.size() > mattes.size(); }

    display::FrameBuffer frame_buffer;
    std::vector<geoaovs::Cryptomatte> mattes;
    std::vector<display::SampleSink*> sinks;  ///< the caller's, then those of the mattes
    /// Channels that share sums of light; null: some consumer reads the samples of every channel.
    std::unique_ptr<const display::SplatSets> splat_sets;
    std::vector<Error> warnings;

  private:
    explicit RenderTarget(display::FrameBuffer buffer) : frame_buffer(std::move(buffer)) {}
    Status make_mattes(const ResolvedJob& job);
};

}  // namespace raylex::transport
