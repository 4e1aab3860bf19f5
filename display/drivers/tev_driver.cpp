#include "display/drivers/tev_driver.h"

#include <charconv>
#include <utility>

#include "display/drivers/packet_sender.h"
#include "display/drivers/tev_protocol.h"

namespace raylex::display {

namespace {

/// Room for a few slices, because newer values are more useful than many old ones.
constexpr std::size_t queue_bytes = 16u << 20;
constexpr double stalled_seconds = 1;  // a viewer that accepts nothing for so long does not get the rest
constexpr double longest_drain_seconds = 10;

class TevDriver : public DisplayDriver {
  public:
    TevDriver(std::string host, int port, std::string name)
        : host_(std::move(host)), port_(port), name_(std::move(name)) {}

    Status open(const DriverImage& image) override {
        if (name_.empty()) name_ = image.title;
        std::vector<std::string> channels;
        for (const DriverLayer& layer : image.layers) {
            planes_.push_back(layer.planes);
            channels.insert(channels.end(), layer.planes.begin(), layer.planes.end());
        }
        sender_ = std::make_unique<PacketSender>(host_, port_, queue_bytes);
        sender_->send(tev::create_image(name_, image.width, image.height, channels));
        return success();
    }
    [[nodiscard]] bool is_live() const override { return sender_ && sender_->failure().empty(); }
    bool region(const DriverRegion& region) override {
        accepted_ = sender_->send(tev::update_image(name_, planes_[region.layer], region.region, region.values));
        return accepted_;
    }
    Status close(const FinishedImage&) override {
        if (!sender_) return success();
        const bool drained = sender_->drain(stalled_seconds, longest_drain_seconds);
        slow_ = !(accepted_ && drained) && sender_->failure().empty();
        return success();
    }
    [[nodiscard]] std::string warning() const override {
        if (!sender_) return {};
        const std::string viewer = "the viewer at " + host_ + ":" + std::to_string(port_);
        if (const std::string failure = sender_->failure(); !failure.empty())
            return viewer + " no longer receives the image (" + failure + "); the render continues without it";
        return slow_ ? viewer + " was too slow to receive all of the finished image" : std::string();
    }

  private:
    std::string host_;
    int port_;
    std::string name_;
    bool accepted_ = true;  // of the last region
    bool slow_ = false;
    std::vector<std::vector<std::string>> planes_;
    std::unique_ptr<PacketSender> sender_;
};

Result<std::unique_ptr<DisplayDriver>> make_tev(const ParameterSet& parameters, const DriverContext&) {
    auto host = parameters.string_or("host", "localhost");
    if (!host) return host.error();
    auto port = parameters.integer_or("port", tev::default_port);
    if (!port) return port.error();
    auto name = parameters.string_or("name", "");
    if (!name) return name.error();
    if (host->empty() || *port < 1 || *port > 65535)
        return error_at(parameters.location, "invalid viewer address '" + *host + ":" + std::to_string(*port) +
                                                 "'; expected a host and a port from 1 to 65535");
    return std::unique_ptr<DisplayDriver>(std::make_unique<TevDriver>(*host, static_cast<int>(*port), *name));
}

}  // namespace

Registry<DisplayDriverFactory>::Entry tev_driver_entry() {
    return {"tev",
            "shows the image in a running tev viewer while it is rendered",
            {{"host", ParameterType::string, "localhost", "where the viewer runs"},
             {"port", ParameterType::integer, std::to_string(tev::default_port), "TCP port of the viewer"},
             {"name", ParameterType::string, "the output's name", "name of the image in the viewer"}},
            make_tev};
}

Result<ParameterSet> tev_address(const std::string& text, const SourceLocation& where) {
    ParameterSet set;
    set.location = where;
    const auto wrong = [&] {
        return error_at(where, "'" + text + "' is not a viewer's address; expected HOST:PORT, such as localhost:14158");
    };
    const std::size_t bracket = text.find(']');
    const bool numeric = !text.empty() && text.front() == '[' && bracket != std::string::npos;
    const std::size_t colon = text.find(':', numeric ? bracket : 0);
    std::string host = numeric ? text.substr(1, bracket - 1) : text.substr(0, colon);
    if (numeric && bracket + 1 != text.size() && colon != bracket + 1) return wrong();
    if (text.empty() || host.find_first_of(" /[]") != std::string::npos) return wrong();
    const auto add = [&](const char* name, ParameterType type) -> Parameter& {
        Parameter& parameter = set.parameters.emplace_back();
        parameter.name = name;
        parameter.type = type;
        parameter.location = where;
        return parameter;
    };
    if (!host.empty()) add("host", ParameterType::string).strings = {host};
    if (colon == std::string::npos) return set;
    int port = 0;
    const char* last = text.data() + text.size();
    const auto [end, failed] = std::from_chars(text.data() + colon + 1, last, port);
    if (failed != std::errc() || end != last || port < 1 || port > 65535) return wrong();
    add("port", ParameterType::integer).numbers = {static_cast<double>(port)};
    return set;
}

}  // namespace raylex::display
