// Geometric AOVs: the standard names, their definitions, and the code that writes them from first hits, from camera
// rays and from finished samples. README.md has the table; geoaovs.cpp has it as code, with one row per AOV.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/channel.h"
#include "display/services/samples/display_services.h"
#include "geoaovs/shading_batch.h"
#include "lpe/result.h"

namespace raylex::geoaovs {

/// The definition (type, space, filter rule, miss value) of a standard AOV name, or an error that lists the names and
/// suggests a similar one. Names are case-sensitive. Ci is the expression channel of all light.
Result<display::ChannelDefinition> channel_definition(std::string_view name);

/// The power of the scene's unit of length in a standard AOV's values: 1 for positions and depths, -1 for curvature,
/// otherwise 0.
int length_power(const display::ChannelDefinition& channel);
std::vector<std::string> channel_names();

/// The geometric AOVs among a render's channels.
///
/// The callers of the functions, per batch of camera rays:
///   write          the integrator, for the batch's first hits; any number of calls, each hit once
///   write_rays     the engine, after the integrator and before sample filters: depths, from SampleTable::depth, so
///                  that they follow WriteDistance
///   write_samples  the engine, after the sample filters: values of the finished samples
class GeometricAovs {
  public:
    /// The index in `channels` is the ChannelId. Channels that are not geometric AOVs, by name or by type, are skipped.
    explicit GeometricAovs(std::span<const display::ChannelDefinition> channels);

    /// The columns of a ShadingBatch that the requested AOVs use; 0: no hits are needed.
    [[nodiscard]] Inputs inputs() const { return inputs_; }
    /// Whether write_rays() and write_samples() have anything to do, and whether samples must be timed.
    [[nodiscard]] bool wants_rays() const { return !rays_.empty(); }
    [[nodiscard]] bool wants_samples() const { return !samples_.empty(); }
    [[nodiscard]] bool wants_time() const { return wants_time_; }

    /// Writes every requested AOV of hits. The services refuse and count values that are not finite. The integrator
    /// always writes the distance that z rules compare (WriteDistance), whether or not an AOV is requested.
    void write(const ShadingBatch& hits, display::DisplayServices& services) const;
    void write_rays(const RayBatch& rays, display::SampleTable& table, display::DisplayServices& services) const;
    /// `seconds`: CPU time of the whole batch, divided equally among its camera rays.
    void write_samples(double seconds, display::SampleTable& table, display::DisplayServices& services) const;

  private:
    struct Request {
        std::size_t aov;
        display::ChannelId id;
    };  // aov: row in the table of AOVs
    std::vector<Request> hits_, rays_, samples_;
    Inputs inputs_ = 0;
    bool wants_time_ = false;
};

}  // namespace raylex::geoaovs
