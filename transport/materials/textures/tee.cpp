#include "transport/materials/textures/tee.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

#include "geoaovs/geoaovs.h"

namespace raylex::transport {
namespace {

class Tee final : public Pattern {
  public:
    Tee(TextureId input, std::string channel) : input_(input), channel_(std::move(channel)) {}
    [[nodiscard]] Rgb rgb(const PatternPoint& point) const override {
        const Rgb value = point.rgb(input_);
        if (display::DisplayServices* display = point.display()) write(*display, point.at.row, value);
        return value;
    }
    [[nodiscard]] Real real(const PatternPoint& point) const override {
        const Real value = point.real(input_);
        if (display::DisplayServices* display = point.display()) write(*display, point.at.row, value);
        return value;
    }

  private:
    template <class Value>
    void write(display::DisplayServices& display, int row, const Value& value) const {
        const display::ChannelId id = find(display.get_display_channels());
        if (id != display::invalid_channel) display.write(id, row, to_float(value));
    }
    /// A scene outlives renders, whose channels differ: where the name stood last time is looked at first, and
    /// verified.
    [[nodiscard]] display::ChannelId find(std::span<const display::DisplayChannel> channels) const {
        const std::size_t last = last_.load(std::memory_order_relaxed);
        if (last < channels.size() && is_mine(channels[last])) return channels[last].id;
        const auto found = std::find_if(channels.begin(), channels.end(), [this](const auto& c) { return is_mine(c); });
        if (found == channels.end()) return display::invalid_channel;
        last_.store(static_cast<std::size_t>(found - channels.begin()), std::memory_order_relaxed);
        return found->id;
    }
    [[nodiscard]] bool is_mine(const display::DisplayChannel& channel) const {
        return channel.style == display::ChannelStyle::name && channel.name == channel_;
    }

    TextureId input_;
    std::string channel_;
    mutable std::atomic<std::size_t> last_{0};
};

Result<std::unique_ptr<Pattern>> make_tee(PatternReader& reader) {
    const TextureId input = reader.input("input", 1);
    return std::unique_ptr<Pattern>(std::make_unique<Tee>(input, reader.string("channel", "")));
}

/// The name of the channel, by the texture's parameter.
Result<std::string> channel_of(const SceneTexture& texture) {
    const Parameter* parameter = texture.parameters.find("channel");
    if (parameter == nullptr || parameter->type != ParameterType::string || parameter->strings.size() != 1 ||
        parameter->strings.front().empty())
        return error_at(
            parameter != nullptr ? parameter->location : texture.location,
            "tee texture '" + texture.name + "' names no channel; expected \"string channel\" with one name");
    return parameter->strings.front();
}

}  // namespace

Registry<PatternFactory>::Entry tee_entry() {
    return {"tee",
            "its input, written to a display channel on the way",
            {{"input", ParameterType::texture, "1", "a colour, a number or a texture"},
             {"channel", ParameterType::string, "", "name of the channel, by which --aov asks for it"}},
            make_tee};
}

Result<std::vector<display::ChannelDefinition>> tee_channels(const SceneDescription& scene) {
    std::vector<display::ChannelDefinition> channels;
    for (const SceneTexture& texture : scene.textures) {
        if (texture.type != "tee") continue;
        const Result<std::string> name = channel_of(texture);
        if (!name) return name.error();
        const SourceLocation& where = texture.parameters.find("channel")->location;
        if (*name == "beauty" || geoaovs::channel_definition(*name))
            return error_at(where, "tee texture '" + texture.name + "' writes to the channel '" + *name +
                                       "', which is one of raylex's own; expected another name");
        display::ChannelDefinition channel;
        channel.name = *name;
        channel.style = display::ChannelStyle::name;
        channel.type = texture.spectrum ? display::ChannelType::rgb : display::ChannelType::real;
        if (texture.spectrum) channel.space = "rendering colour space";
        channel.origin = where.file;
        channel.origin_line = where.line;
        channel.origin_column = where.column;
        const auto earlier =
            std::find_if(channels.begin(), channels.end(), [&](const auto& c) { return c.name == *name; });
        if (earlier == channels.end()) channels.push_back(std::move(channel));
        else if (earlier->type != channel.type)
            return error_at(where, "channel '" + *name + "' is a " + (texture.spectrum ? "float" : "spectrum") +
                                       " channel already, by line " + std::to_string(earlier->origin_line) +
                                       "; expected another name");
    }
    return channels;
}

}  // namespace raylex::transport
