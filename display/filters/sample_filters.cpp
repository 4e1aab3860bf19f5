// The sample filters grade and shadow.
#include "display/filters/sample_filters.h"

#include <algorithm>
#include <utility>

#include "display/filters/grade.h"

namespace raylex::display {
namespace {

class GradeFilter final : public SampleFilter {
  public:
    GradeFilter(Grade grade, std::vector<ChannelId> changed, bool alone)
        : grade_(grade), changed_(std::move(changed)), alone_(alone) {}

    void apply(SampleTable& table) const override {
        for (const ChannelId id : changed_) {
            if (!table.touched(id) && grade_.is_linear()) continue;  // a linear grade maps 0 to 0
            const int components = component_count(table.channel(id).type);
            const bool plain = table.channel(id).style == ChannelStyle::name;
            if (!plain && !grade_.is_linear() && table.row_count() > table.camera_row_count()) {
                grade_sums(table, id);
            } else {
                for (int row = 0; row < table.row_count(); ++row)
                    if (!plain || table.written(id, row)) grade_.apply(table.edit(id, row).data(), components);
            }
        }
    }
    [[nodiscard]] std::vector<ChannelId> alters() const override {
        return alone_ ? changed_ : std::vector<ChannelId>();
    }

  private:
    /// The light of a sample is the sum of its rows, so offset and power apply to the sum.
    void grade_sums(SampleTable& table, ChannelId id) const {
        const double* const values = table.values(id);
        std::vector<RgbD> sums(static_cast<std::size_t>(table.camera_row_count()));
        for (int row = 0; row < table.row_count(); ++row) {
            const double* v = values + 3 * static_cast<std::size_t>(row);
            sums[static_cast<std::size_t>(table.original(row))] += RgbD(v[0], v[1], v[2]);
        }
        for (std::size_t row = 0; row < sums.size(); ++row) {
            const RgbD change = grade_.apply(sums[row]) - sums[row];
            const std::span<double> value = table.edit(id, static_cast<int>(row));
            for (std::size_t c = 0; c < 3; ++c) value[c] += change[static_cast<int>(c)];
        }
    }

    Grade grade_;
    std::vector<ChannelId> changed_;
    bool alone_;  // applies to named channels, not to all light
};

Result<std::unique_ptr<SampleFilter>> build_sample_grade(const ParameterSet& parameters,
                                                         const SampleFilterContext& context) {
    const std::string who = "sample filter 'grade'";
    const auto grade = read_grade(parameters, who);
    if (!grade) return grade.error();
    const std::vector<ChannelDefinition> channels(context.channels.begin(), context.channels.end());
    auto changed = graded_channels(*grade, parameters, channels, context.beauty, who);
    if (!changed) return changed.error();
    const bool alone = !read_names(parameters, "channels").empty();
    return std::unique_ptr<SampleFilter>(std::make_unique<GradeFilter>(*grade, std::move(*changed), alone));
}

struct ShadowSetup {
    ChannelId light = invalid_channel;  // unoccluded light
    ChannelId other = invalid_channel;  // light that arrives, or that is blocked
    bool other_is_held_back = false;
    double threshold = 0;
    bool alpha = true;
    ChannelId output = invalid_channel;
};

class ShadowFilter final : public SampleFilter {
  public:
    explicit ShadowFilter(const ShadowSetup& setup) : setup_(setup) {}

    void apply(SampleTable& table) const override {
        if (!table.touched(setup_.light)) return;
        for (int row = 0; row < table.row_count(); ++row) {
            const double light = brightness(table, setup_.light, row);
            if (!(light > setup_.threshold)) continue;
            const double ratio = brightness(table, setup_.other, row) / light;
            const double shadow = std::clamp(setup_.other_is_held_back ? ratio : 1 - ratio, 0.0, 1.0);
            if (setup_.alpha) {
                RgbD& opacity = table.opacity[static_cast<std::size_t>(row)];
                opacity = RgbD(1.0) - (RgbD(1.0) - opacity) * (1 - shadow);
            }
            if (setup_.output < 0) continue;
            table.edit(setup_.output, row)[0] = shadow;
            // Splatted, because rows of a sample add up: what is behind a cutout counts by the cutout's transmittance.
            table.set_row_state(setup_.output, row, SampleTable::RowState::splatted);
        }
    }

  private:
    static double brightness(const SampleTable& table, ChannelId id, int row) {
        const double* v = table.values(id) + 3 * static_cast<std::size_t>(row);
        return luminance(RgbD(v[0], v[1], v[2]));
    }
    ShadowSetup setup_;
};

/// The id of one light channel by name.
Result<ChannelId> light_channel(const ParameterSet& parameters, const SampleFilterContext& context, const char* key,
                                const std::string& name) {
    const std::vector<ChannelDefinition> channels(context.channels.begin(), context.channels.end());
    const std::string who = "sample filter 'shadow'";
    const auto ids = named_channels({name}, channels, invalid_channel, parameters, who);
    if (!ids) return ids.error();
    if (channels[static_cast<std::size_t>(ids->front())].style != ChannelStyle::expression)
        return error_at(parameters.location,
                        who + " has " + key + " = '" + name +
                            "', which is not a light path expression; expected a channel of light");
    return ids->front();
}

Result<std::unique_ptr<SampleFilter>> build_shadow(const ParameterSet& parameters, const SampleFilterContext& context) {
    const std::string who = "sample filter 'shadow'";
    const auto text = [&](const char* name) { return parameters.string_or(name, ""); };
    const auto unoccluded = text("unoccluded"), occluded = text("occluded"), shadows = text("shadows"),
               output = text("channel");
    for (const auto* each : {&unoccluded, &occluded, &shadows, &output})
        if (!*each) return each->error();
    const auto threshold = parameters.real_or("threshold", 0.01);
    if (!threshold) return threshold.error();
    const auto alpha = parameters.boolean_or("alpha", true);
    if (!alpha) return alpha.error();
    if (unoccluded->empty() || occluded->empty() == shadows->empty())
        return error_at(parameters.location,
                        who +
                            " needs unoccluded light, and either the light that arrives or the light that is "
                            "blocked; expected unoccluded=NAME with shadows=NAME or occluded=NAME");
    if (!(*threshold >= 0)) return error_at(parameters.location, who + " has a threshold below 0; expected 0 or above");
    ShadowSetup setup;
    setup.threshold = *threshold;
    setup.alpha = *alpha;
    setup.other_is_held_back = !shadows->empty();
    const auto light = light_channel(parameters, context, "unoccluded", *unoccluded);
    if (!light) return light.error();
    setup.light = *light;
    const auto other = setup.other_is_held_back ? light_channel(parameters, context, "shadows", *shadows)
                                                : light_channel(parameters, context, "occluded", *occluded);
    if (!other) return other.error();
    setup.other = *other;
    if (!output->empty()) {
        ChannelDefinition layer;
        layer.name = *output;
        layer.type = ChannelType::real;
        const auto id = context.add_channel
                            ? context.add_channel(std::move(layer))
                            : Result<ChannelId>(error_at(parameters.location, who + " cannot add a channel here"));
        if (!id) return id.error();
        setup.output = *id;
    }
    if (!setup.alpha && setup.output < 0)
        return error_at(parameters.location,
                        who + " has no destination for the shadow; expected alpha=true or channel=NAME");
    return std::unique_ptr<SampleFilter>(std::make_unique<ShadowFilter>(setup));
}

}  // namespace

Registry<SampleFilterFactory>::Entry grade_filter_entry() {
    return {"grade", "exposure, gain, offset, gamma and saturation of samples", grade_parameters(), build_sample_grade};
}

Registry<SampleFilterFactory>::Entry shadow_filter_entry() {
    return {"shadow",
            "the blocked fraction of the light, sample by sample, in alpha or a layer",
            {{"unoccluded", ParameterType::string, "", "channel of the unoccluded light"},
             {"shadows", ParameterType::string, "", "channel of the blocked part of it: shadow = shadows / unoccluded"},
             {"occluded", ParameterType::string, "",
              "or channel of the part that arrives: shadow = 1 - occluded / unoccluded"},
             {"threshold", ParameterType::real, "0.01",
              "luminance that unoccluded must exceed; below it there is no shadow"},
             {"alpha", ParameterType::boolean, "true", "composites the shadow over the sample's opacity"},
             {"channel", ParameterType::string, "", "name of a new layer for the shadow; none: no layer"}},
            build_shadow};
}

}  // namespace raylex::display
