// Reads the image while threads add to it, tile by tile, under their locks. Private to transport/render.
#pragma once

#include "transport/render/stages/render_state.h"

namespace raylex::transport {

class TiledImage final : public LiveImage {
  public:
    explicit TiledImage(const RenderState& state)
        : grid_(state.prepared.job.grid),
          channels_(state.prepared.job.channels.list),
          frame_buffer_(state.target.frame_buffer),
          locks_(state.locks) {}

    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                               const display::PixelRegion& region) const override;

  private:
    template <class Read>
    [[nodiscard]] std::vector<double> by_tiles(const display::PixelRegion& region, std::size_t components,
                                               Read read) const;
    const TileGrid& grid_;
    std::span<const display::ChannelDefinition> channels_;
    const display::FrameBuffer& frame_buffer_;
    TileLocks& locks_;
};

}  // namespace raylex::transport
