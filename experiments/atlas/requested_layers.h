// Layers computed from an atlas: sums of words.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/buffer/plane.h"
#include "display/output/atlas/atlas_file.h"
#include "experiments/atlas/path_string_answers.h"
#include "experiments/atlas/what_if.h"
#include "experiments/job/channels/channel_plan.h"
#include "experiments/mix/mix.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct AskSettings {
    bool intervals = false;  ///< channels that are not exact become NAME_least and NAME_most
    bool errors = false;     ///< adds NAME_error, the standard error of each layer's mean (R + G + B) / 3
    Mix mix{};               ///< factors for lights and colours
};

/// The beauty of the render and the requested layers, with the interface of a frame buffer.
class RequestedLayers final : public display::PixelImage {
  public:
    static constexpr display::ChannelId beauty = 0;

    /// Computes the expression channels of the plan, in their order. If `changed` gives only bounds, beauty_least and
    /// beauty_most are added, and the beauty is the middle of both. Errors: channels
    /// that an atlas does not have (geometric AOVs, prefixes, techniques); osl channels of an atlas without straight
    /// events; a channel that accepts only a part of a word, which the error names, unless intervals are requested; a
    /// damaged file.
    static Result<RequestedLayers> make(display::AtlasFile& atlas, const ChannelPlan& plan, const AskSettings& settings,
                                        const WhatIf& changed);

    [[nodiscard]] const display::FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const display::ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override;
    /// Names of the channels that became intervals. Partitions with such a channel are not declared.
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

/// Compiles the expression channels of a plan. `program_channel` [plan channel] is the channel's index in the program,
/// or -1 without an expression.
Result<lpe::Program> compile_plan(const ChannelPlan& plan, std::vector<std::int32_t>& program_channel);

/// Returns the standard error of a sum of words' means (R + G + B) / 3. `luminance` has the sum over each eighth of the
/// samples, `counts` the number of samples of each eighth. Let K eighths have samples, with fractions n_k of all
/// samples, means m_k, and the mean m of the m_k weighted by n_k:
///     error^2 = sum n_k (m_k - m)^2 / (K - 1).
/// Infinite if K < 2.
double standard_error(const std::array<double, display::PathAtlas::parts>& luminance,
                      const std::array<float, display::PathAtlas::parts>& counts);

}  // namespace raylex::experiments
