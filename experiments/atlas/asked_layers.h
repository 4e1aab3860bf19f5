// Layers made of an atlas instead of paths: sums of words.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/buffer/plane.h"
#include "display/output/atlas/atlas_file.h"
#include "experiments/atlas/word_answers.h"
#include "experiments/job/channels/channel_plan.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct AskSettings {
    bool intervals = false;  ///< channels that the atlas cannot answer become NAME_least and NAME_most
    bool errors = false;     ///< NAME_error, the standard error of each layer's mean (R + G + B) / 3
};

/// The render's beauty and the layers asked for, as a frame buffer would hold them.
class AskedLayers final : public display::PixelImage {
  public:
    static constexpr display::ChannelId beauty = 0;

    /// Of the plan's expression channels, in their order. Errors: channels that no atlas has (geometric AOVs, prefixes,
    /// techniques); osl channels of an atlas without the cutouts that light passed; what the atlas cannot tell apart,
    /// unless intervals are wanted, naming a word; a damaged file.
    static Result<AskedLayers> make(display::AtlasFile& atlas, const ChannelPlan& plan, const AskSettings& settings);

    [[nodiscard]] const display::FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const display::ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override;
    /// Channels of the plan that became intervals: partitions with these are none.
    [[nodiscard]] const std::vector<std::string>& undecided() const { return undecided_; }

  private:
    struct Layer {
        std::size_t components = 3;
        display::Plane<float> pixels;
    };
    class Builder;
    display::FrameBufferLayout layout_;
    std::vector<display::ChannelDefinition> channels_;
    std::vector<Layer> layers_;  // [channel]
    display::Plane<float> alpha_;
    std::vector<std::string> undecided_;
};

/// Compiles the expression channels of a plan, `program_channel` [plan channel] their places; -1: no expression.
Result<lpe::Program> compile_plan(const ChannelPlan& plan, std::vector<std::int32_t>& program_channel);

/// The standard error of a sum of words' means (R + G + B) / 3, from what the eighths of the samples brought to it;
/// `counts` is how many samples they are. With shares n_k of the samples and means m_k of the eighths that had any (K
/// of them), m their mean weighted by n_k:
///     error^2 = sum n_k (m_k - m)^2 / (K - 1).
/// Infinite where fewer than two eighths had samples.
double standard_error(const std::array<double, display::PathAtlas::parts>& luminance,
                      const std::array<float, display::PathAtlas::parts>& counts);

}  // namespace raylex::experiments
