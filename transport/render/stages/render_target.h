// The third stage: what samples end up in, once the caller has seen the plan and memory is taken. Private to
// transport/render.
#pragma once

#include <memory>
#include <vector>

#include "transport/render/stages/prepared_job.h"

namespace raylex::transport {

/// What the caller learns before the first ray, memory included: of the whole image.
RenderPlan plan_of(const ResolvedJob& job);
/// Of the image, or of the bucket that the job is in.
display::FrameBufferLayout layout_of(const ResolvedJob& job);

class RenderTarget {
  public:
    /// Of the image, or the bucket that the job is in: what takes in its samples, beside the caller's sinks. An Error
    /// says that memory does not suffice.
    static Result<RenderTarget> allocate(const PreparedJob& prepared, std::vector<display::SampleSink*> sinks);

    /// Whether some sink keeps raw samples, as deep images do: they cannot be saved, nor taken back.
    [[nodiscard]] bool has_sinks_of_others() const { return sinks.size() > mattes.size(); }

    display::FrameBuffer frame_buffer;
    std::vector<geoaovs::Cryptomatte> mattes;
    std::vector<display::SampleSink*> sinks;  ///< the caller's, then those of the mattes
    /// Null: something looks at the samples of every channel one by one.
    std::unique_ptr<const display::SplatSets> splat_sets;
    std::vector<Error> warnings;

  private:
    explicit RenderTarget(display::FrameBuffer buffer) : frame_buffer(std::move(buffer)) {}
    Status make_mattes(const ResolvedJob& job);
};

}  // namespace raylex::transport
