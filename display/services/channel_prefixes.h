// The prefixes of a light path expression ("unoccluded;holdouts;C[DS]+<L.>"). They define what a channel splats instead
// of the arriving radiance, and do not affect which path strings the expression accepts.
//
// Sources: RenderMan's public wiki (page "Holdouts": occluded and unoccluded channels with the prefix `holdouts` "only
// contain the shadowing term for holdout geometry"), the channel definitions of RenderManForBlender, and the manual of
// Unity Eddy (page "Custom and Advanced AOVs": unoccluded is "the radiance with all shadowing disabled", shadow the
// difference between it and the occluded radiance). For everything else lpe/README.md defines the behaviour.
#pragma once

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "lpe/language/prefixes.h"

namespace raylex::display {

struct ChannelPrefixes {
    bool unoccluded = false;       ///< light samples ignore occluders
    bool shadows = false;          ///< the blocked part of light samples: unoccluded minus occluded
    bool nothruput = false;        ///< the emitted radiance, or the user value, without the path's throughput
    bool holdouts = false;         ///< only paths whose first hit is a holdout
    bool overwrite = false;        ///< the last contribution of a camera sample replaces earlier ones
    bool noinfinitecheck = false;  ///< checks only its own value for validity, not the beauty's (Law 6 applies to it,
                                   ///< too)
    bool noclamp = false;          ///< sample filters do not change it
    bool unweighted = false;       ///< without the MIS weight
    std::optional<lpe::TechniquePrefix> technique;  ///< only contributions of these techniques

    /// Returns whether the channel takes a value other than beauty's, or takes it in a different way.
    [[nodiscard]] bool own_value() const {
        return unoccluded || shadows || nothruput || overwrite || noinfinitecheck || unweighted ||
               technique.has_value();
    }
    /// Returns whether the channel needs the EmitterSample beside the value.
    [[nodiscard]] bool emitter_sample() const { return unoccluded || shadows || nothruput; }
    /// Returns whether the channel takes a contribution of technique `found_by`. Null stands for a surface event, which
    /// no technique finds.
    [[nodiscard]] bool takes(const Technique* found_by) const {
        if (!technique) return true;
        if (found_by == nullptr) return false;
        if (technique->t == 0) return found_by->s + found_by->t > technique->beyond;
        return found_by->s == technique->s && found_by->t == technique->t;
    }
    /// Returns whether the channel is meaningful only where lights are sampled.
    [[nodiscard]] bool light_samples() const { return unoccluded || shadows; }
    bool operator==(const ChannelPrefixes&) const = default;
};

/// Reads the prefixes of the channel's expression. A channel without an expression has none. Errors: the expression
/// does not parse; prefixes contradict each other, such as `shadows` and `unoccluded`.
Result<ChannelPrefixes> read_prefixes(const ChannelDefinition& channel);

/// The position of the channel's expression, for errors.
SourceLocation location_of(const ChannelDefinition& channel);

}  // namespace raylex::display
