// Sample filters change the raw samples of a batch, all channels at once, before any pixel filter.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "display/services/channel.h"
#include "display/services/registry.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// One object serves all threads: apply() changes only the table, once per batch, after the integrator.
class SampleFilter {
  public:
    virtual ~SampleFilter() = default;
    virtual void apply(SampleTable& table) const = 0;
    /// Channels that the filter changes differently from beauty and all light layers together, so that partitions
    /// containing them no longer sum (Law 1). Such a partition is not declared in files, and a warning is shown.
    [[nodiscard]] virtual std::vector<ChannelId> alters() const { return {}; }
    /// Returns whether the filter is also meaningful for splats, whose rows belong to no camera ray.
    [[nodiscard]] virtual bool fits_splats() const { return false; }
};

/// Filters in the order of their application.
class SampleFilterChain {
  public:
    void add(std::unique_ptr<SampleFilter> filter) { filters_.push_back(std::move(filter)); }
    [[nodiscard]] bool empty() const { return filters_.empty(); }
    /// Applies all filters, then removes values that they made and that are not finite (Law 6): light is removed from
    /// beauty and all light layers of its row, any other value from its channel. The table counts them.
    void apply(SampleTable& table) const;
    [[nodiscard]] std::vector<ChannelId> alters() const;
    [[nodiscard]] bool fits_splats() const;

  private:
    static void take_out_invalid(SampleTable& table);
    std::vector<std::unique_ptr<SampleFilter>> filters_;
};

/// The properties of the render for which a filter is made.
struct SampleFilterContext {
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
    /// Adds a plain channel that the filter fills; its name must be unused. Empty if channels cannot be added.
    std::function<Result<ChannelId>(ChannelDefinition)> add_channel{};
};

using SampleFilterFactory =
    std::function<Result<std::unique_ptr<SampleFilter>>(const ParameterSet&, const SampleFilterContext&)>;

/// The filters "none", "clamp", "grade" and "shadow" (filters/sample_filters.h).
///
/// clamp scales a sample whose beauty is brighter than "luminance" to that luminance. One factor per camera sample,
/// from its beauty over all its rows, scales beauty and every expression channel, so that splits still sum (Law 1).
/// Channels with the prefix `noclamp` are not changed. It needs a beauty channel.
Registry<SampleFilterFactory>& sample_filter_registry();

/// Makes the filter of that name with these parameters. Errors, at the set's location: no such filter, a wrong or
/// unknown parameter.
Result<std::unique_ptr<SampleFilter>> make_sample_filter(const std::string& name, const ParameterSet& parameters,
                                                         const SampleFilterContext& context);

}  // namespace raylex::display
