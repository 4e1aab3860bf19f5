// The sum of the images of passes.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// Positions of the channels of the sum in a list of channels, by name; invalid_channel where the list lacks one.
std::vector<display::ChannelId> positions_in(std::span<const display::ChannelDefinition> channels,
                                             std::span<const display::ChannelDefinition> of_sum);

/// Whether the values of passes are added: channels of light and their statistics.
bool is_summed(std::span<const display::ChannelDefinition> channels, display::ChannelId id);

/// One rendered pass.
struct PassImage {
    display::FrameBuffer buffer;
    std::vector<display::ChannelId> position;  ///< positions_in(buffer.channels(), channels of the sum)
    /// The first half of the samples of a pass whose light lands on any pixel. The scatter of a pixel's samples does
    /// not give its error then, but the difference of the halves does.
    std::optional<display::FrameBuffer> half{};

    /// Returns the pixels of a channel of the sum; empty if the pass has no light for it.
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id,
                                              std::span<const display::ChannelDefinition> channels,
                                              const display::PixelRegion& region) const;
};

/// Adds light over the passes in their order. Everything else comes from one of them.
class PassSum final : public display::PixelImage {
  public:
    PassSum(std::vector<PassImage> images, std::size_t with_aovs, std::vector<display::ChannelDefinition> channels)
        : images_(std::move(images)), with_aovs_(with_aovs), channels_(std::move(channels)) {}
    [[nodiscard]] const display::FrameBufferLayout& layout() const override { return images_.front().buffer.layout(); }
    [[nodiscard]] std::span<const display::ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override {
        return images_[with_aovs_].buffer.resolve_alpha(region);
    }

  private:
    std::vector<PassImage> images_;
    std::size_t with_aovs_;
    std::vector<display::ChannelDefinition> channels_;
};

/// The finished passes and the running one, for live views. The first of all is the one with the AOVs.
class LivePassSum final : public transport::LiveImage {
  public:
    LivePassSum(std::span<const PassImage* const> finished, const transport::LiveImage& running,
                std::vector<display::ChannelId> position, std::span<const display::ChannelDefinition> channels)
        : finished_(finished), running_(running), position_(std::move(position)), channels_(channels) {}
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                               const display::PixelRegion& region) const override;

  private:
    std::span<const PassImage* const> finished_;
    const transport::LiveImage& running_;
    std::vector<display::ChannelId> position_;
    std::span<const display::ChannelDefinition> channels_;
};

}  // namespace raylex::experiments
