// The prefixes of a light path expression ("unoccluded;holdouts;C[DS]+<L.>"): what a channel splats instead of the
// radiance that arrives. Which words the expression accepts is not their business.
//
// Sources: RenderMan's public wiki (page "Holdouts": occluded and unoccluded channels with the prefix `holdouts` "only
// contain the shadowing term for holdout geometry"), the channel definitions of RenderManForBlender, and the manual of
// Unity Eddy (page "Custom and Advanced AOVs": unoccluded is "the radiance with all shadowing disabled", shadow the
// difference between it and the occluded radiance). Where they are silent, lpe/README.md says what holds here.
#pragma once

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "lpe/language/prefixes.h"

namespace raylex::display {

struct ChannelPrefixes {
    bool unoccluded = false;       ///< light samples count as if nothing were in the way
    bool shadows = false;          ///< what is in the way of light samples: unoccluded minus occluded
    bool nothruput = false;        ///< what the emitter sends, or the user value, without the path's throughput
    bool holdouts = false;         ///< paths whose first hit is a holdout, and no others
    bool overwrite = false;        ///< the last contribution of a camera sample replaces earlier ones
    bool noinfinitecheck = false;  ///< judged by its own value alone, whatever the beauty's is (Law 6 holds for it too)
    bool noclamp = false;          ///< sample filters leave it alone
    bool unweighted = false;       ///< without the MIS weight
    std::optional<lpe::TechniquePrefix> technique;  ///< what these techniques find, and nothing else

    /// Takes something else than the value that beauty takes, or takes it in another way.
    [[nodiscard]] bool own_value() const {
        return unoccluded || shadows || nothruput || overwrite || noinfinitecheck || unweighted ||
               technique.has_value();
    }
    /// Needs the EmitterSample beside the value.
    [[nodiscard]] bool emitter_sample() const { return unoccluded || shadows || nothruput; }
    /// Whether what `technique` found is its own; null: a surface's event, which no technique finds.
    [[nodiscard]] bool takes(const Technique* found_by) const {
        if (!technique) return true;
        if (found_by == nullptr) return false;
        if (technique->t == 0) return found_by->s + found_by->t > technique->beyond;
        return found_by->s == technique->s && found_by->t == technique->t;
    }
    /// Makes sense only where lights are sampled.
    [[nodiscard]] bool light_samples() const { return unoccluded || shadows; }
    bool operator==(const ChannelPrefixes&) const = default;
};

/// Those of the channel's expression; none for a channel without one. Errors: the expression does not parse; prefixes
/// that contradict each other, such as `shadows` and `unoccluded`.
Result<ChannelPrefixes> read_prefixes(const ChannelDefinition& channel);

/// Where the channel's expression stands, for errors.
SourceLocation location_of(const ChannelDefinition& channel);

}  // namespace raylex::display
