// The path atlas of raylex render: its buffer (a sample sink), its file, and the check of that file.
#pragma once

#include <memory>
#include <optional>

#include "display/output/atlas/atlas_file.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

class AtlasOutput {
  public:
    /// Makes the render record words, if the job requests an atlas. Errors: other settings of the job that exclude an
    /// atlas.
    Status prepare(Job& job, const ScenePathStrings& scene);
    /// Makes the buffer. Errors: a render plan that excludes an atlas.
    Status make(const Job& job, const transport::RenderPlan& plan);
    /// The buffer, or null without an atlas.
    [[nodiscard]] display::PathAtlas* buffer() const { return buffer_.get(); }
    /// Writes the atlas to its file. If that fails, writes it to the folder for temporary files; the error names the
    /// new path.
    Status write(const transport::RenderOutput& output, const display::ImageDescription& description);
    /// Reads the written file and checks that its path strings sum to its beauty. Returns nothing without an atlas.
    Result<std::optional<display::AtlasCheck>> run_checks() const;

  private:
    const AtlasRequest* request_ = nullptr;
    std::string scene_record_;
    display::SignedLight negative_ = display::SignedLight::none;
    std::shared_ptr<const display::PathAlphabet> alphabet_;
    std::unique_ptr<display::PixelFilter> raster_filter_;
    std::unique_ptr<display::PathAtlas> buffer_;
};

}  // namespace raylex::experiments
