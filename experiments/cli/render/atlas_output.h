// The path atlas of raylex render: its buffer among the sinks, its file, and what that file is judged by.
#pragma once

#include <memory>
#include <optional>

#include "display/output/atlas/atlas_file.h"
#include "experiments/job/channels/scene_words.h"
#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

class AtlasOutput {
  public:
    /// Has the render keep words, if the job asks for an atlas. Errors: what the job asks for beside it and cannot
    /// have.
    Status prepare(Job& job, const SceneWords& scene);
    /// Makes the buffer. Errors: what an atlas cannot be made of.
    Status make(const Job& job, const transport::RenderPlan& plan);
    /// Null when there is no atlas.
    [[nodiscard]] display::PathAtlas* buffer() const { return buffer_.get(); }
    /// To its file, or else to the folder for temporary files, as the error says.
    Status write(const transport::RenderOutput& output, const display::ImageDescription& description);
    /// The file just written, its words against its beauty; nothing when there is none.
    Result<std::optional<display::AtlasVerdict>> judge() const;

  private:
    const AtlasRequest* request_ = nullptr;
    std::string scene_record_;
    display::SignedLight negative_ = display::SignedLight::none;
    std::shared_ptr<const display::WordAlphabet> alphabet_;
    std::unique_ptr<display::PixelFilter> raster_filter_;
    std::unique_ptr<display::PathAtlas> buffer_;
};

}  // namespace raylex::experiments
