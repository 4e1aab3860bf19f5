// Geometric AOVs: the standard names, what each means, and the code that writes them from first hits.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/channel.h"
#include "display/services/display_services.h"
#include "geoaovs/shading_batch.h"
#include "lpe/result.h"

namespace raylex::geoaovs {

/// The definition (type, space, filter rule, miss value) of a standard AOV name, or an error listing near misses.
Result<display::ChannelDefinition> channel_definition(std::string_view name);
std::vector<std::string> channel_names();

/// The geometric AOVs among a render's channels, found once; writes them for a batch of first hits.
class GeometricAovs {
  public:
    /// `channels[i].id` must be i; channels that are no geometric AOV are passed over.
    explicit GeometricAovs(std::span<const display::ChannelDefinition> channels);
    [[nodiscard]] bool empty() const { return requests_.empty(); }
    [[nodiscard]] bool wants_albedo() const;          ///< the only input that costs a BSDF look-up
    void write(const ShadingBatch& hits, display::DisplayServices& services) const;

  private:
    struct Request { int row; display::ChannelId id; };   // row of the table of AOVs
    std::vector<Request> requests_;
};

}  // namespace raylex::geoaovs
