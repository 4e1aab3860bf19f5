#include "display/filters/display_filter.h"

#include <algorithm>
#include <utility>

#include "display/filters/grade.h"
#include "display/services/object_request.h"

namespace raylex::display {
namespace {

class GradeDisplay final : public DisplayFilter {
  public:
    GradeDisplay(Grade grade, std::vector<ChannelId> changed, bool alone)
        : grade_(grade), changed_(std::move(changed)), alone_(alone) {}

    [[nodiscard]] bool changes(ChannelId id) const override {
        return std::find(changed_.begin(), changed_.end(), id) != changed_.end();
    }
    void apply(const PixelImage& before, ChannelId id, const PixelRegion&, std::span<double> pixels) const override {
        const int components = component_count(before.channels()[static_cast<std::size_t>(id)].type);
        for (std::size_t i = 0; i < pixels.size(); i += static_cast<std::size_t>(components))
            grade_.apply(&pixels[i], components);
    }
    [[nodiscard]] std::vector<ChannelId> alters() const override {
        return alone_ ? changed_ : std::vector<ChannelId>();
    }

  private:
    Grade grade_;
    std::vector<ChannelId> changed_;
    bool alone_;  // applies to named channels, not to all light
};

Result<std::unique_ptr<DisplayFilter>> build_display_grade(const ParameterSet& parameters,
                                                           const DisplayFilterContext& context) {
    const std::string who = "display filter 'grade'";
    const auto grade = read_grade(parameters, who);
    if (!grade) return grade.error();
    const std::vector<ChannelDefinition> channels(context.channels.begin(), context.channels.end());
    auto changed = graded_channels(*grade, parameters, channels, context.beauty, who);
    if (!changed) return changed.error();
    const bool alone = !read_names(parameters, "channels").empty();
    return std::unique_ptr<DisplayFilter>(std::make_unique<GradeDisplay>(*grade, std::move(*changed), alone));
}

/// beauty + (1 - alpha) x colour, because colours are premultiplied.
class Background final : public DisplayFilter {
  public:
    Background(const RgbD& color, ChannelId beauty) : color_(color), beauty_(beauty) {}

    [[nodiscard]] bool changes(ChannelId id) const override { return id == beauty_; }
    [[nodiscard]] bool changes_alpha() const override { return true; }
    void apply(const PixelImage& before, ChannelId, const PixelRegion& region,
               std::span<double> pixels) const override {
        const std::vector<double> alpha = before.resolve_alpha(region);
        for (std::size_t i = 0; i < alpha.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c) pixels[3 * i + c] += (1 - alpha[i]) * color_[static_cast<int>(c)];
    }
    void apply_alpha(const PixelImage&, const PixelRegion&, std::span<double> alpha) const override {
        std::fill(alpha.begin(), alpha.end(), 1.0);
    }
    [[nodiscard]] std::vector<ChannelId> alters() const override { return {beauty_}; }

  private:
    RgbD color_;
    ChannelId beauty_;
};

Result<std::unique_ptr<DisplayFilter>> build_background(const ParameterSet& parameters,
                                                        const DisplayFilterContext& context) {
    const auto color = read_triple(parameters, "color", 0, "display filter 'background'");
    if (!color) return color.error();
    if (context.beauty < 0)
        return error_at(parameters.location,
                        "display filter 'background' needs a beauty channel, and this render has none; "
                        "expected a beauty channel");
    return std::unique_ptr<DisplayFilter>(std::make_unique<Background>(*color, context.beauty));
}

Registry<DisplayFilterFactory> in_tree_filters() {
    Registry<DisplayFilterFactory> registry("display filter");
    registry.add(
        {"grade", "exposure, gain, offset, gamma and saturation of pixels", grade_parameters(), build_display_grade});
    registry.add({"background",
                  "the beauty over a colour; its alpha becomes 1",
                  {{"color", ParameterType::rgb, "0", "one number, or red, green and blue: rendering colour space"}},
                  build_background});
    return registry;
}

}  // namespace

/// The image after one filter.
class FilteredImage::Stage final : public PixelImage {
  public:
    Stage(const PixelImage& before, const DisplayFilter& filter) : before_(before), filter_(filter) {}
    [[nodiscard]] const FrameBufferLayout& layout() const override { return before_.layout(); }
    [[nodiscard]] int band_end(int y) const override { return before_.band_end(y); }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return before_.channels(); }
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override {
        std::vector<double> pixels = before_.resolve(id, region);
        if (filter_.changes(id)) filter_.apply(before_, id, region, pixels);
        return pixels;
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override {
        std::vector<double> alpha = before_.resolve_alpha(region);
        if (filter_.changes_alpha()) filter_.apply_alpha(before_, region, alpha);
        return alpha;
    }

  private:
    const PixelImage& before_;
    const DisplayFilter& filter_;
};

FilteredImage::FilteredImage(const PixelImage& image, std::span<const std::unique_ptr<DisplayFilter>> filters) {
    images_.push_back(&image);
    for (const auto& filter : filters) {
        stages_.push_back(std::make_unique<Stage>(last(), *filter));
        images_.push_back(stages_.back().get());
    }
}

Registry<DisplayFilterFactory>& display_filter_registry() {
    static Registry<DisplayFilterFactory> registry = in_tree_filters();
    return registry;
}

Result<std::unique_ptr<DisplayFilter>> make_display_filter(const std::string& name, const ParameterSet& parameters,
                                                           const DisplayFilterContext& context) {
    const auto entry = display_filter_registry().require(name, parameters.location);
    if (!entry) return entry.error();
    auto filter = (*entry)->factory(parameters, context);
    if (!filter) return filter;
    if (Status used = check_all_used(parameters, (*entry)->parameters, "display filter", name); !used)
        return used.error();
    return filter;
}

}  // namespace raylex::display
