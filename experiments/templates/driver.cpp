// @NAME@: a display driver that writes the beauty or one layer as a Portable Float Map (P. Debevec): 32-bit floats,
// bottom row first.
#include <fstream>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::display;

class PfmDriver final : public DisplayDriver {
  public:
    PfmDriver(std::string file, std::string layer, SourceLocation where)
        : file_(std::move(file)), layer_(std::move(layer)), where_(std::move(where)) {}

    Status open(const DriverImage& image) override {
        std::vector<std::string> known;
        for (const DriverLayer& each : image.layers) {
            known.push_back(each.name);
            if (each.name != layer_ || component_count(each.type) != 3) continue;
            channel_ = each.channel;
            width_ = image.width;
            height_ = image.height;
            return success();
        }
        const std::string near = nearest_name(layer_, known);
        return error_at(where_, "display driver '@NAME@': no layer '" + layer_ + "' with three numbers per pixel",
                        near.empty() ? std::string() : "did you mean '" + near + "'?");
    }

    Status close(const FinishedImage& image) override {
        const std::vector<double> values = image.frame_buffer.resolve(channel_);
        std::ofstream out(file_, std::ios::binary);
        out << "PF\n" << width_ << ' ' << height_ << "\n-1.0\n";  // -1: little endian
        for (int y = height_; y-- > 0;)
            for (int i = 0; i < 3 * width_; ++i) {
                const auto value = static_cast<float>(values[static_cast<std::size_t>(3 * width_ * y + i)]);
                out.write(reinterpret_cast<const char*>(&value), sizeof value);
            }
        out.close();
        if (!out) return error_at(where_, "display driver '@NAME@' cannot write '" + file_ + "'");
        return success();
    }

    [[nodiscard]] std::string file() const override { return file_; }

  private:
    std::string file_, layer_;
    SourceLocation where_;
    ChannelId channel_ = invalid_channel;
    int width_ = 0, height_ = 0;
};

Result<std::unique_ptr<DisplayDriver>> make(const ParameterSet& parameters, const DriverContext&) {
    transport::ParameterReader reader(parameters);
    const std::string file = reader.string("file", ""), layer = reader.string("layer", "");
    if (file.empty())
        reader.fail(error_at(parameters.location, "display driver '@NAME@' has no file; expected file=NAME.pfm"));
    if (reader.error()) return *reader.error();
    return std::unique_ptr<DisplayDriver>(std::make_unique<PfmDriver>(file, layer, parameters.location));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_display_driver(
        {"@NAME@",
         "writes a Portable Float Map",
         {{"file", ParameterType::string, "", "file to write"},
          {"layer", ParameterType::string, "", "layer with three numbers per pixel; default: the beauty"}},
         make});
}
