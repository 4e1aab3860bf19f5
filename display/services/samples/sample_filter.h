// Sample filters: they see the raw samples of a batch, all channels at once, before any pixel filter.
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
    /// Channels that change in another way than beauty and all light layers together do, so that partitions they are in
    /// no longer sum (Law 1). Such a partition is not declared in files, and the user is told.
    [[nodiscard]] virtual std::vector<ChannelId> alters() const { return {}; }
    /// Whether it means something for splats too, each a row that belongs to no camera ray.
    [[nodiscard]] virtual bool fits_splats() const { return false; }
};

/// Filters in the order in which they see the samples.
class SampleFilterChain {
  public:
    void add(std::unique_ptr<SampleFilter> filter) { filters_.push_back(std::move(filter)); }
    [[nodiscard]] bool empty() const { return filters_.empty(); }
    /// Applies all, then takes out what they made that is not finite (Law 6): a light sample leaves beauty and all
    /// light layers of its row, any other value its channel. Counted in the table.
    void apply(SampleTable& table) const;
    [[nodiscard]] std::vector<ChannelId> alters() const;
    [[nodiscard]] bool fits_splats() const;

  private:
    static void take_out_invalid(SampleTable& table);
    std::vector<std::unique_ptr<SampleFilter>> filters_;
};

/// What a filter may know of the render it is made for.
struct SampleFilterContext {
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
    /// Adds a plain channel that the filter fills; its name must not be taken. Empty where there can be none.
    std::function<Result<ChannelId>(ChannelDefinition)> add_channel{};
};

using SampleFilterFactory =
    std::function<Result<std::unique_ptr<SampleFilter>>(const ParameterSet&, const SampleFilterContext&)>;

/// "none", "clamp", "grade" and "shadow" (filters/sample_filters.h).
///
/// clamp lowers a sample whose beauty is brighter than "luminance" to that luminance. One factor per camera sample,
/// taken from its beauty over all its rows, scales beauty and every expression channel alike, so that splits still sum
/// (Law 1); channels with the prefix `noclamp` are left alone. It needs a beauty channel.
Registry<SampleFilterFactory>& sample_filter_registry();

/// The filter of that name built from its parameters, or an error at the set's location; a parameter that it does not
/// take is an error too.
Result<std::unique_ptr<SampleFilter>> make_sample_filter(const std::string& name, const ParameterSet& parameters,
                                                         const SampleFilterContext& context);

}  // namespace raylex::display
