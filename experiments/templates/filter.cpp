// @NAME@: a sample filter that applies a camera exposure in stops to samples. The beauty and every light path
// expression get the same factor, so splits still sum to the beauty. The filter also writes the factor to its own
// channel.
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::display;

class Exposure final : public SampleFilter {
  public:
    Exposure(double factor, std::vector<ChannelId> light, ChannelId used)
        : factor_(factor), light_(std::move(light)), used_(used) {}
    /// Called once per batch, after the integrator, with the samples of all channels. edit() returns the numbers of a
    /// row, which then count as sent.
    void apply(SampleTable& table) const override {
        for (int row = 0; row < table.row_count(); ++row) {
            for (const ChannelId id : light_)
                if (table.touched(id))
                    for (double& value : table.edit(id, row)) value *= factor_;
            table.edit(used_, row)[0] = factor_;
        }
    }

  private:
    double factor_;
    std::vector<ChannelId> light_;
    ChannelId used_;
};

Result<std::unique_ptr<SampleFilter>> make(const ParameterSet& parameters, const SampleFilterContext& context) {
    transport::ParameterReader reader(parameters);
    const float stops = reader.real("stops", 0, -20, 20);
    if (reader.error()) return *reader.error();
    std::vector<ChannelId> light;
    for (std::size_t i = 0; i < context.channels.size(); ++i)
        if (context.channels[i].style == ChannelStyle::expression) light.push_back(static_cast<ChannelId>(i));
    const Result<ChannelId> used = context.add_channel(declared_channel("@NAME@_factor", ChannelType::real));
    if (!used) return used.error();
    return std::unique_ptr<SampleFilter>(
        std::make_unique<Exposure>(std::exp2(static_cast<double>(stops)), std::move(light), *used));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_sample_filter({"@NAME@",
                            "makes all light brighter or darker, before the adaptive sampler measures it",
                            {{"stops", ParameterType::real, "0", "exposure; each stop doubles the light; -20 to 20"}},
                            make});
}
