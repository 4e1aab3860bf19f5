// Everything a render leaves beside its statistics: drivers, the deep image, and the account of memory.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/deep/deep_buffer.h"
#include "display/drivers/driver_set.h"
#include "display/filters/display_filter.h"
#include "display/output/writer/deep_file.h"
#include "experiments/cli/render/atlas_output.h"
#include "experiments/job/job.h"
#include "experiments/job/rendering/color_setup.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Files that a job asks for, the main image first; for the checks before a render.
std::vector<std::string> requested_files(const Job& job);

class RenderOutputs;
/// Prints what the layers will take, of at most `limit` bytes (0: no limit). After RenderOutputs::begin().
void print_memory(const RenderOutputs& outputs, std::uint64_t limit);

class RenderOutputs {
  public:
    /// Makes the drivers; a job without an output has no main image. Errors: whatever a driver refuses. `color` must
    /// outlive this object.
    Status make(const Job& job, const ColorSetup& color);

    /// Before memory is taken: refuses more than the limit, makes the display
    /// filters, opens the drivers and makes the deep buffer one of the render's sinks. Partitions that filters break
    /// are taken out of the list, with a warning.
    Status begin(const transport::RenderPlan& plan, std::vector<display::SampleSink*>& sinks,
                 const display::Chromaticities& primaries, std::vector<display::PartitionDeclaration>& partitions);

    void update(const transport::RenderProgress& progress);

    /// Writes all. The image, the deep image or the atlas go to the folder for temporary files where they cannot be
    /// written, as the errors say: the first of them is returned, others become warnings.
    Status close(const transport::RenderOutput& output, const display::ImageDescription& description);

    /// The image as files and viewers get it: through the display filters. It and this object must outlive the result.
    [[nodiscard]] display::FilteredImage filtered(const display::PixelImage& image) const { return {image, filters_}; }

    /// Flattens the deep file against the image just written. Nothing when none was asked for, or when display filters,
    /// which a deep image never sees, changed the image.
    Result<std::optional<display::DeepVerdict>> judge_deep(const display::ExrImage& image) const;

    [[nodiscard]] AtlasOutput& atlas() { return atlas_; }

    [[nodiscard]] std::vector<std::string> take_warnings();
    /// Beside the main image.
    [[nodiscard]] std::vector<std::string> files() const;
    [[nodiscard]] const std::vector<display::MemoryItem>& memory() const { return memory_; }
    /// Of a render in buckets: how many, and how many rows one has at most; else 0.
    [[nodiscard]] std::size_t buckets() const { return buckets_; }
    [[nodiscard]] int bucket_rows() const { return bucket_rows_; }
    /// Of the file, cryptomattes among them.
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
    std::vector<std::string> warnings_;
    display::FrameBufferLayout layout_;
    std::size_t buckets_ = 0;
    int bucket_rows_ = 0;
};

/// "deep: 3 layers flatten to the image (...)".
std::string deep_line(const display::DeepVerdict& verdict);

}  // namespace raylex::experiments
