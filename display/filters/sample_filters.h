// The built-in sample filters except clamp, as entries for sample_filter_registry().
#pragma once

#include "display/services/samples/sample_filter.h"

namespace raylex::display {

/// The filter grade: see filters/grade.h. Without "channels" it applies the same linear map to beauty and every light
/// layer, so that splits still sum (Law 1).
Registry<SampleFilterFactory>::Entry grade_filter_entry();

/// The filter shadow: per sample the blocked fraction of light, from a pair of channels such as
/// `holdouts;shadows;C[DS]+<L.>` and `holdouts;unoccluded;C[DS]+<L.>`, as the ratio of their luminances. With `shadows`
/// both use the same light samples, so the ratio is exact for each sample. With `occluded` (RenderMan's pair) it is
/// exact if the integrator finds light only by light sampling; it is noisy if the integrator weights two techniques,
/// because unoccluded light has only one of them.
Registry<SampleFilterFactory>::Entry shadow_filter_entry();

}  // namespace raylex::display
