// Sample filters: they see the raw samples of a batch, all channels at once, before any pixel filter.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/registry.h"
#include "display/services/sample_table.h"

namespace raylex::display {

/// One object serves all threads: apply() changes only the table, once per batch, after the integrator.
class SampleFilter {
  public:
    virtual ~SampleFilter() = default;
    virtual void apply(SampleTable& table) const = 0;
};

/// What a filter may know of the render it is made for.
struct SampleFilterContext {
    std::span<const ChannelDefinition> channels;
    ChannelId beauty = invalid_channel;
};

using SampleFilterFactory =
    std::function<Result<std::unique_ptr<SampleFilter>>(const ParameterSet&, const SampleFilterContext&)>;

/// "none" and "clamp".
///
/// clamp lowers a sample whose beauty is brighter than "luminance" to that luminance. One factor per camera sample,
/// taken from its beauty over all its rows, scales beauty and every expression channel alike, so that splits still sum
/// (Law 1); channels with the prefix `noclamp` are left alone. It needs a beauty channel.
Registry<SampleFilterFactory>& sample_filter_registry();

/// The filter of that name built from its parameters, or an error at the set's location.
Result<std::unique_ptr<SampleFilter>> make_sample_filter(const std::string& name, const ParameterSet& parameters,
                                                         const SampleFilterContext& context);

}  // namespace raylex::display
