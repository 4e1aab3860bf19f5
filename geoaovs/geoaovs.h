// Geometric AOVs: the standard names, what each means, and the code that writes them from first hits. README.md has the
// table; geoaovs.cpp has the same as code, one row per AOV.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/channel.h"
#include "display/services/display_services.h"
#include "geoaovs/shading_batch.h"
#include "lpe/result.h"

namespace raylex::geoaovs {

/// The definition (type, space, filter rule, miss value) of a standard AOV name, or an error that lists what there is and
/// the near miss. Names are case-sensitive.
Result<display::ChannelDefinition> channel_definition(std::string_view name);
std::vector<std::string> channel_names();

/// The geometric AOVs among a render's channels, found once; writes them for a batch of first hits.
class GeometricAovs {
  public:
    /// The index in `channels` is the ChannelId. Channels that are no geometric AOV, by name or by type, are passed over.
    explicit GeometricAovs(std::span<const display::ChannelDefinition> channels);
    [[nodiscard]] bool empty() const { return requests_.empty(); }
    [[nodiscard]] bool wants_albedo() const;          ///< the only input that costs a BSDF look-up
    /// Writes the distance that z rules compare, and every AOV asked for. A value that is not finite is refused and counted
    /// by the services.
    void write(const ShadingBatch& hits, display::DisplayServices& services) const;

  private:
    struct Request { std::size_t aov; display::ChannelId id; };   // row of the table of AOVs
    std::vector<Request> requests_;
};

}  // namespace raylex::geoaovs
