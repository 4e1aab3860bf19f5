// In-tree sample filters beside clamp: the rows that sample_filter_registry() has of them.
#pragma once

#include "display/services/samples/sample_filter.h"

namespace raylex::display {

/// grade: see filters/grade.h. Without "channels" it scales beauty and every light layer by the same linear map, so
/// that splits still sum (Law 1).
Registry<SampleFilterFactory>::Entry grade_filter_entry();

/// shadow: per sample the share of light that is held back, from a pair of channels such as
/// `holdouts;shadows;C[DS]+<L.>` and `holdouts;unoccluded;C[DS]+<L.>`, by the ratio of their luminances. With `shadows`
/// the ratio is that of one and the same light samples and exact for each; with `occluded` (RenderMan's pair) it is
/// exact where the integrator finds light by sampling alone, and noisy where it weighs two techniques, since unoccluded
/// light has one of them only.
Registry<SampleFilterFactory>::Entry shadow_filter_entry();

}  // namespace raylex::display
