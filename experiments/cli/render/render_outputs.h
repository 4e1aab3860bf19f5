// All outputs of a render except its statistics: drivers, the deep image, the atlas, and the memory report.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/deep/deep_buffer.h"
#include "display/drivers/driver_set.h"
#include "display/filters/display_filter.h"
#include "display/output/denoise/denoised_image.h"
#include "display/output/writer/deep_file.h"
#include "experiments/cli/render/atlas_output.h"
#include "experiments/job/job.h"
#include "experiments/job/rendering/color_setup.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Returns the files that a job requests, the main image first, for checks before a render.
std::vector<std::string> requested_files(const Job& job);

class RenderOutputs;
/// Prints the memory of the layers and the limit, `limit` bytes (0: no limit). Call it after RenderOutputs::begin().
void print_memory(const RenderOutputs& outputs, std::uint64_t limit);

class RenderOutputs {
  public:
    /// Makes the drivers. A job without an output has no main image. Errors: those of the drivers. `color` must outlive
    /// this object.
    Status make(const Job& job, const ColorSetup& color);

    /// Prepares the outputs before the frame buffer is allocated: checks the memory limit, makes the display filters,
    /// opens the drivers and adds the deep buffer to the render's sinks. Removes partitions that filters break from the
    /// list, with a warning.
    Status begin(const transport::RenderPlan& plan, std::vector<display::SampleSink*>& sinks,
                 const display::Chromaticities& primaries, std::vector<display::PartitionDeclaration>& partitions);

    void update(const transport::RenderProgress& progress);

    /// Writes all outputs. An image, deep image or atlas that cannot be written is saved to the folder for temporary
    /// files, which its error names. Returns the first error; later ones become warnings.
    Status close(const transport::RenderOutput& output, const display::ImageDescription& description);

    /// Returns the image that files and viewers receive, after the display filters. `image` and this object must
    /// outlive it.
    [[nodiscard]] display::FilteredImage filtered(const display::PixelImage& image) const { return {image, filters_}; }

    /// Flattens the deep file and compares it with the image just written. Returns nothing without a deep image, or if
    /// display filters or the denoiser, which do not apply to deep images, changed the image.
    Result<std::optional<display::DeepCheck>> report_deep_check(const display::ExrImage& image) const;

    [[nodiscard]] AtlasOutput& atlas() { return atlas_; }

    [[nodiscard]] std::vector<std::string> take_warnings();
    /// The errors of denoised layers, one line each; empty without --denoise.
    [[nodiscard]] const std::vector<std::string>& denoised() const { return denoised_; }
    /// Names of the output files except the main image.
    [[nodiscard]] std::vector<std::string> files() const;
    [[nodiscard]] const std::vector<display::MemoryItem>& memory() const { return memory_; }
    /// Number of buckets and of the rows of the largest bucket; 0 if the render has no buckets.
    [[nodiscard]] std::size_t buckets() const { return buckets_; }
    [[nodiscard]] int bucket_rows() const { return bucket_rows_; }
    /// Number of layers in the file, including cryptomattes.
    [[nodiscard]] std::size_t layers() const {
        const transport::RenderSettings& settings = job_->settings;
        return channels_.size() + settings.mattes.kinds.size() * static_cast<std::size_t>(settings.mattes.ranks) / 2;
    }
    [[nodiscard]] const display::DeepBuffer* deep() const { return deep_.get(); }

  private:
    void drop_altered(const transport::RenderPlan& plan, std::vector<display::PartitionDeclaration>& partitions);
    Status check_buckets(const transport::RenderPlan& plan);
    Status make_deep(const transport::RenderPlan& plan);
    const Job* job_ = nullptr;
    display::DriverSet drivers_;
    std::unique_ptr<display::DeepBuffer> deep_;
    AtlasOutput atlas_;
    std::vector<display::MemoryItem> memory_;
    std::vector<display::ChannelDefinition> channels_;
    std::vector<std::unique_ptr<display::DisplayFilter>> filters_;
    std::vector<std::string> warnings_, denoised_;
    display::FrameBufferLayout layout_;
    std::size_t buckets_ = 0;
    int bucket_rows_ = 0;
};

/// Returns the options of a job for its denoiser.
display::DenoiseOptions denoise_options(const Job& job);

/// Returns the result of the deep check in one line: "deep: 3 layers flatten to the image (...)".
std::string deep_line(const display::DeepCheck& result);

}  // namespace raylex::experiments
