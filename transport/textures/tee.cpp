#include "transport/textures/tee.h"

#include <algorithm>
#include <string>
#include <utility>

#include "geoaovs/geoaovs.h"

namespace raylex::transport {
namespace {

class Tee final : public Pattern {
  public:
    Tee(TextureId input, std::string channel) : input_(input), channel_(std::move(channel)) {}
    [[nodiscard]] Rgb rgb(const PatternPoint& point) const override { return written(point, point.rgb(input_)); }
    [[nodiscard]] Real real(const PatternPoint& point) const override { return written(point, point.real(input_)); }

  private:
    template <class Value>
    [[nodiscard]] Value written(const PatternPoint& point, const Value& value) const {
        if (const VertexServices& services = point.services(); services.camera_sees())
            services.display->write(channel_.id(services.display->get_display_channels()), services.row,
                                    to_float(value));
        return value;
    }

    TextureId input_;
    display::NamedChannel channel_;
};

Result<std::unique_ptr<Pattern>> make_tee(PatternReader& reader) {
    const TextureId input = reader.input("input", 1);
    return std::unique_ptr<Pattern>(std::make_unique<Tee>(input, reader.string("channel", "")));
}

/// Whether textures of this type name a channel as tees do: with a string parameter called "channel".
bool names_channel(const std::string& type) {
    const auto* entry = pattern_registry().find(type);
    return entry != nullptr &&
           std::any_of(entry->parameters.begin(), entry->parameters.end(), [](const ParameterDescription& each) {
               return each.name == "channel" && each.type == ParameterType::string;
           });
}

/// The name of the channel from the texture's parameter; empty if a pattern other than a tee omits it.
Result<std::string> channel_of(const SceneTexture& texture) {
    const Parameter* parameter = texture.parameters.find("channel");
    if (parameter == nullptr && texture.type != "tee") return std::string();
    if (parameter == nullptr || parameter->type != ParameterType::string || parameter->strings.size() != 1 ||
        parameter->strings.front().empty())
        return error_at(parameter != nullptr ? parameter->location : texture.location,
                        texture.type + " texture '" + texture.name +
                            "' names no channel; expected \"string channel\" with one name");
    return parameter->strings.front();
}

}  // namespace

Registry<PatternFactory>::Entry tee_entry() {
    return {"tee",
            "passes its input through and writes it to a display channel",
            {{"input", ParameterType::texture, "1", "a colour, a number or a texture"},
             {"channel", ParameterType::string, "", "name of the channel, for --aov"}},
            make_tee};
}

Result<std::vector<display::ChannelDefinition>> texture_channels(const SceneDescription& scene) {
    std::vector<display::ChannelDefinition> channels;
    for (const SceneTexture& texture : scene.textures) {
        if (!names_channel(texture.type)) continue;
        const Result<std::string> name = channel_of(texture);
        if (!name) return name.error();
        if (name->empty()) continue;
        const SourceLocation& where = texture.parameters.find("channel")->location;
        if (*name == "beauty" || geoaovs::channel_definition(*name))
            return error_at(where, texture.type + " texture '" + texture.name + "' writes to the channel '" + *name +
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
