#include "display/services/samples/sample_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "display/filters/sample_filters.h"
#include "display/services/channel_prefixes.h"
#include "display/services/object_request.h"

namespace raylex::display {
namespace {

class NoFilter final : public SampleFilter {
  public:
    void apply(SampleTable&) const override {}
    [[nodiscard]] bool fits_splats() const override { return true; }
};

class ClampFilter final : public SampleFilter {
  public:
    /// `by_component`: the limit applies to the largest component of `measure` times the colour, otherwise to the
    /// luminance.
    ClampFilter(double limit, bool by_component, const std::array<RgbD, 3>& measure, ChannelId beauty,
                std::vector<ChannelId> scaled)
        : limit_(limit), by_component_(by_component), measure_(measure), beauty_(beauty), scaled_(std::move(scaled)) {}

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
    [[nodiscard]] bool fits_splats() const override { return true; }

  private:
    static RgbD color(const double* values, int row) {
        const double* v = values + 3 * static_cast<std::size_t>(row);
        return {v[0], v[1], v[2]};
    }
    [[nodiscard]] double factor(const RgbD& beauty) const {
        const auto measured = [&](const RgbD& row) { return row.r * beauty.r + row.g * beauty.g + row.b * beauty.b; };
        const double brightness = by_component_
                                      ? std::max({measured(measure_[0]), measured(measure_[1]), measured(measure_[2])})
                                      : static_cast<double>(luminance(beauty));
        return brightness > limit_ ? limit_ / brightness : 1.0;
    }
    void scale(SampleTable& table, int row, double factor) const {
        if (factor == 1.0) return;
        for (const ChannelId id : scaled_) {
            if (!table.touched(id)) continue;
            for (double& v : table.edit(id, row)) v *= factor;
        }
    }

    double limit_;
    bool by_component_;
    std::array<RgbD, 3> measure_;  // rows
    ChannelId beauty_;
    std::vector<ChannelId> scaled_;  // beauty and expression channels
};

Result<std::unique_ptr<SampleFilter>> build_none(const ParameterSet&, const SampleFilterContext&) {
    return std::unique_ptr<SampleFilter>(std::make_unique<NoFilter>());
}

/// Reads the matrix of the clamp by rows; the default is the unit matrix.
Result<std::array<RgbD, 3>> read_measure(const ParameterSet& parameters) {
    std::array<RgbD, 3> rows{RgbD{1, 0, 0}, RgbD{0, 1, 0}, RgbD{0, 0, 1}};
    const Parameter* given = parameters.find("measure");
    if (given == nullptr) return rows;
    given->used = true;
    if (parameters.find("component") == nullptr)
        return error_at(given->location, "sample filter 'clamp' has a 'measure' without a 'component'; expected both");
    const bool numbers = given->type == ParameterType::real || given->type == ParameterType::integer;
    if (!numbers || given->numbers.size() != 9 ||
        !std::all_of(given->numbers.begin(), given->numbers.end(), [](double each) { return std::isfinite(each); }))
        return error_at(given->location,
                        "'measure' of sample filter 'clamp' is not a matrix; expected nine finite numbers, row by row");
    for (std::size_t r = 0; r < 3; ++r)
        rows[r] = {given->numbers[3 * r], given->numbers[3 * r + 1], given->numbers[3 * r + 2]};
    return rows;
}

Result<std::unique_ptr<SampleFilter>> build_clamp(const ParameterSet& parameters, const SampleFilterContext& context) {
    const bool by_component = parameters.find("component") != nullptr;
    const char* const measure = by_component ? "component" : "luminance";
    const Result<double> limit = parameters.real_or(measure, 10.0);
    if (!limit) return limit.error();
    if (!(*limit > 0))
        return error_at(parameters.location, std::string("sample filter 'clamp' has ") + measure + " " +
                                                 std::to_string(*limit) + "; expected a value above 0");
    if (by_component && parameters.find("luminance") != nullptr)
        return error_at(parameters.location,
                        "sample filter 'clamp' has both a luminance and a component; expected one of them");
    const auto rows = read_measure(parameters);
    if (!rows) return rows.error();
    if (context.beauty < 0)
        return error_at(parameters.location,
                        "sample filter 'clamp' needs a beauty channel, and this render has none; expected "
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
    return std::unique_ptr<SampleFilter>(
        std::make_unique<ClampFilter>(*limit, by_component, *rows, context.beauty, std::move(scaled)));
}

Registry<SampleFilterFactory> in_tree_filters() {
    Registry<SampleFilterFactory> registry("sample filter");
    registry.add({"none", "does not change samples", {}, build_none});
    registry.add({"clamp",
                  "scales samples brighter than a luminance down to it, all light channels by one factor",
                  {{"luminance", ParameterType::real, "10", "largest luminance a sample keeps, > 0"},
                   {"component", ParameterType::real, "",
                    "instead: largest component a sample keeps, > 0, as the \"maxcomponentvalue\" of pbrt's films"},
                   {"measure", ParameterType::real, "",
                    "nine numbers, row by row: a matrix; the component is that of the matrix times the colour"}},
                  build_clamp});
    registry.add(grade_filter_entry());
    registry.add(shadow_filter_entry());
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
    auto filter = (*entry)->factory(parameters, context);
    if (!filter) return filter;
    if (Status used = check_all_used(parameters, (*entry)->parameters, "sample filter", name); !used)
        return used.error();
    return filter;
}

void SampleFilterChain::apply(SampleTable& table) const {
    if (filters_.empty()) return;
    for (const auto& filter : filters_) filter->apply(table);
    take_out_invalid(table);
}

void SampleFilterChain::take_out_invalid(SampleTable& table) {
    const auto finite = [](const double* v, int components) {
        return std::all_of(v, v + components, [](double each) { return std::isfinite(each); });
    };
    const auto value_at = [&](ChannelId id, int row) {
        return table.raw_values(id) +
               static_cast<std::size_t>(row) * static_cast<std::size_t>(component_count(table.channel(id).type));
    };
    std::vector<ChannelId> light;
    for (ChannelId id = 0; id < table.channel_count(); ++id)
        if (table.touched(id) && table.channel(id).style == ChannelStyle::expression) light.push_back(id);
    for (ChannelId id = 0; id < table.channel_count(); ++id) {
        if (!table.touched(id) || !takes_samples(table.channel(id))) continue;
        const int components = component_count(table.channel(id).type);
        const bool is_light = table.channel(id).style == ChannelStyle::expression;
        for (int row = 0; row < table.row_count(); ++row) {
            if (!is_light && !table.written(id, row)) continue;  // the miss value, which can be infinite
            double* v = value_at(id, row);
            if (finite(v, components)) continue;
            const Rgb shown(static_cast<float>(v[0]), static_cast<float>(v[components / 2]),
                            static_cast<float>(v[components - 1]));
            table.count_invalid(row, id, shown);
            if (!is_light) {
                std::fill_n(v, components, table.fill_value(id));
                table.set_row_state(id, row, SampleTable::RowState::untouched);
            }
            for (const ChannelId other : is_light ? light : std::vector<ChannelId>())
                std::fill_n(value_at(other, row), component_count(table.channel(other).type), 0.0);
        }
    }
    for (int row = 0; row < table.row_count(); ++row) {
        RgbD& opacity = table.opacity[static_cast<std::size_t>(row)];
        if (is_finite(opacity)) continue;
        table.count_invalid(row, invalid_channel, Rgb(opacity));
        opacity = RgbD();
    }
}

bool SampleFilterChain::fits_splats() const {
    return std::all_of(filters_.begin(), filters_.end(), [](const auto& filter) { return filter->fits_splats(); });
}

std::vector<ChannelId> SampleFilterChain::alters() const {
    std::vector<ChannelId> ids;
    for (const auto& filter : filters_) {
        const std::vector<ChannelId> more = filter->alters();
        ids.insert(ids.end(), more.begin(), more.end());
    }
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
}

}  // namespace raylex::display
