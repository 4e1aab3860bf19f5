// Geometric AOVs: the standard names, what each means, and the code that writes them from first hits, from camera rays
// and from finished samples. README.md has the table; geoaovs.cpp has the same as code, one row per AOV.
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

/// The definition (type, space, filter rule, miss value) of a standard AOV name, or an error that lists what there is
/// and the near miss. Names are case-sensitive. Ci comes as the expression channel of all light.
Result<display::ChannelDefinition> channel_definition(std::string_view name);

/// The power of the scene's unit of length in a standard AOV's values: 1 of positions and depths, -1 of curvature, else
/// 0.
int length_power(const display::ChannelDefinition& channel);
std::vector<std::string> channel_names();

/// The geometric AOVs among a render's channels, found once.
///
/// Who writes when, per batch of camera rays:
///   write          the integrator, for the batch's first hits; any number of times, each hit once
///   write_rays     the engine, after the integrator and before sample filters: depths, from SampleTable::depth, so
///   that
///                  they follow WriteDistance
///   write_samples  the engine, after the sample filters: what the samples have come to
class GeometricAovs {
  public:
    /// The index in `channels` is the ChannelId. Channels that are no geometric AOV, by name or by type, are passed
    /// over.
    explicit GeometricAovs(std::span<const display::ChannelDefinition> channels);

    /// Columns of a ShadingBatch that the AOVs asked for read; 0: no hit needs to be described.
    [[nodiscard]] Inputs inputs() const { return inputs_; }
    /// Whether write_rays and write_samples have anything to do, and whether samples are to be timed.
    [[nodiscard]] bool wants_rays() const { return !rays_.empty(); }
    [[nodiscard]] bool wants_samples() const { return !samples_.empty(); }
    [[nodiscard]] bool wants_time() const { return wants_time_; }

    /// Writes every AOV of hits asked for. A value that is not finite is refused and counted by the services. The
    /// distance that z rules compare is the integrator's to write (WriteDistance), whether or not anybody asks for an
    /// AOV.
    void write(const ShadingBatch& hits, display::DisplayServices& services) const;
    void write_rays(const RayBatch& rays, display::SampleTable& table, display::DisplayServices& services) const;
    /// `seconds`: CPU time that the whole batch took, shared equally among its camera rays.
    void write_samples(double seconds, display::SampleTable& table, display::DisplayServices& services) const;

  private:
    struct Request {
        std::size_t aov;
        display::ChannelId id;
    };  // row of the table of AOVs
    std::vector<Request> hits_, rays_, samples_;
    Inputs inputs_ = 0;
    bool wants_time_ = false;
};

}  // namespace raylex::geoaovs
