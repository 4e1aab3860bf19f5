#include "display/services/sample_filter.h"

#include <algorithm>
#include <utility>

#include "display/services/channel_prefixes.h"

namespace raylex::display {
namespace {

class NoFilter final : public SampleFilter {
  public:
    void apply(SampleTable&) const override {}
};

class ClampFilter final : public SampleFilter {
  public:
    ClampFilter(double limit, ChannelId beauty, std::vector<ChannelId> scaled)
        : limit_(limit), beauty_(beauty), scaled_(std::move(scaled)) {}

    void apply(SampleTable& table) const override {
        if (!table.touched(beauty_)) return;
        const double* beauty = table.values(beauty_);
        const int cameras = table.camera_row_count(), rows = table.row_count();
        if (rows == cameras) {
            for (int row = 0; row < rows; ++row) scale(table, row, factor(color(beauty, row)));
            return;
        }
        std::vector<RgbD> total(static_cast<std::size_t>(cameras));
        for (int row = 0; row < rows; ++row) total[static_cast<std::size_t>(table.original(row))] += color(beauty, row);
        for (int row = 0; row < rows; ++row)
            scale(table, row, factor(total[static_cast<std::size_t>(table.original(row))]));
    }

  private:
    static RgbD color(const double* values, int row) {
        const double* v = values + 3 * static_cast<std::size_t>(row);
        return {v[0], v[1], v[2]};
    }
    [[nodiscard]] double factor(const RgbD& beauty) const {
        const double brightness = luminance(beauty);
        return brightness > limit_ ? limit_ / brightness : 1.0;
    }
    void scale(SampleTable& table, int row, double factor) const {
        if (factor == 1.0) return;
        for (const ChannelId id : scaled_) {
            if (!table.touched(id)) continue;
            const int components = component_count(table.channel(id).type);
            double* v = table.values(id) + static_cast<std::size_t>(row) * static_cast<std::size_t>(components);
            for (int c = 0; c < components; ++c) v[c] *= factor;
        }
    }

    double limit_;
    ChannelId beauty_;
    std::vector<ChannelId> scaled_;  // beauty and the expression channels
};

Result<std::unique_ptr<SampleFilter>> build_none(const ParameterSet&, const SampleFilterContext&) {
    return std::unique_ptr<SampleFilter>(std::make_unique<NoFilter>());
}

Result<std::unique_ptr<SampleFilter>> build_clamp(const ParameterSet& parameters, const SampleFilterContext& context) {
    const Result<double> limit = parameters.real_or("luminance", 10.0);
    if (!limit) return limit.error();
    if (!(*limit > 0))
        return error_at(parameters.location,
                        "sample filter 'clamp' has luminance " + std::to_string(*limit) + "; expected a value above 0");
    if (context.beauty < 0)
        return error_at(parameters.location,
                        "sample filter 'clamp' derives its factor from beauty, which this render leaves out; expected "
                        "a beauty channel");
    std::vector<ChannelId> scaled{context.beauty};
    for (std::size_t i = 0; i < context.channels.size(); ++i) {
        const ChannelDefinition& channel = context.channels[i];
        const auto id = static_cast<ChannelId>(i);
        if (channel.style != ChannelStyle::expression || id == context.beauty) continue;
        const Result<ChannelPrefixes> prefixes = read_prefixes(channel);
        if (!prefixes) return prefixes.error();
        if (prefixes->noclamp) continue;
        scaled.push_back(id);
    }
    return std::unique_ptr<SampleFilter>(std::make_unique<ClampFilter>(*limit, context.beauty, std::move(scaled)));
}

Registry<SampleFilterFactory> in_tree_filters() {
    Registry<SampleFilterFactory> registry("sample filter");
    registry.add({"none", "leaves the samples as they are", {}, build_none});
    registry.add({"clamp",
                  "scales samples brighter than a luminance down to it, all light channels by one factor",
                  {{"luminance", ParameterType::real, "10", "largest luminance a sample keeps, > 0"}},
                  build_clamp});
    return registry;
}

}  // namespace

Registry<SampleFilterFactory>& sample_filter_registry() {
    static Registry<SampleFilterFactory> registry = in_tree_filters();
    return registry;
}

Result<std::unique_ptr<SampleFilter>> make_sample_filter(const std::string& name, const ParameterSet& parameters,
                                                         const SampleFilterContext& context) {
    const Result<const Registry<SampleFilterFactory>::Entry*> entry =
        sample_filter_registry().require(name, parameters.location);
    if (!entry) return entry.error();
    return (*entry)->factory(parameters, context);
}

}  // namespace raylex::display
