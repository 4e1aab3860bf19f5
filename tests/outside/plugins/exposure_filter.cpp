// A sample filter: camera exposure in stops, on raw samples. One factor for beauty and every light path expression, so
// splits still sum to beauty (Law 1).
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::display;

class Exposure final : public SampleFilter {
  public:
    Exposure(double factor, std::vector<ChannelId> light) : factor_(factor), light_(std::move(light)) {}
    void apply(SampleTable& table) const override {
        for (const ChannelId id : light_) {
            if (!table.touched(id)) continue;
            double* values = table.values(id);
            for (int i = 0; i < 3 * table.row_count(); ++i) values[i] *= factor_;
        }
    }

  private:
    double factor_;
    std::vector<ChannelId> light_;
};

Result<std::unique_ptr<SampleFilter>> make_exposure(const ParameterSet& parameters,
                                                    const SampleFilterContext& context) {
    transport::ParameterReader reader(parameters);
    const float stops = reader.real("stops", 0, -20, 20);
    if (reader.error()) return *reader.error();
    std::vector<ChannelId> light;
    for (std::size_t i = 0; i < context.channels.size(); ++i)
        if (context.channels[i].style == ChannelStyle::expression) light.push_back(static_cast<ChannelId>(i));
    return std::unique_ptr<SampleFilter>(
        std::make_unique<Exposure>(std::exp2(static_cast<double>(stops)), std::move(light)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_sample_filter({"exposure",
                            "makes all light brighter or darker, before the adaptive sampler sees it",
                            {{"stops", ParameterType::real, "0", "each doubles the light; -20 to 20"}},
                            make_exposure});
}
