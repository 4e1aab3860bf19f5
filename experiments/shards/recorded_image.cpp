#include "experiments/shards/recorded_image.h"

#include <stdexcept>

#include "experiments/job/text/json_fields.h"

namespace raylex::experiments {
namespace {

Json point_json(const std::array<double, 2>& xy) {
    return Json::array({xy[0], xy[1]});
}

Json storage_json(const display::ExrStorageTable& table) {
    Json json = Json::object();
    for (std::size_t i = 0; i < table.size(); ++i)
        json[display::kind_name(static_cast<display::ChannelKind>(i))] = display::storage_text(table[i]);
    return json;
}

/// Parses a storage table. Throws if a row is invalid.
display::ExrStorageTable storage_of(const Json& json) {
    display::ExrStorageTable table = display::default_exr_storage();
    for (const auto& [kind, text] : json.items())
        if (Status s = display::override_exr_storage(table, kind, text.get<std::string>(), {}); !s)
            throw std::runtime_error(s.error().message);
    return table;
}

/// The type of a parameter as a number. Reading throws for a number without a type.
struct TypeNumber {
    ParameterType& type;
};
void to_json(Json& json, const TypeNumber& number) {
    json = static_cast<int>(number.type);
}
void from_json(const Json& json, TypeNumber& number) {
    const int type = whole(json);
    if (type < 0 || type > static_cast<int>(ParameterType::texture)) throw std::runtime_error("no type of a parameter");
    number.type = static_cast<ParameterType>(type);
}

Json mattes_json(const std::vector<RecordedMatte>& mattes) {
    Json json = Json::array();
    for (const RecordedMatte& each : mattes) {
        // JSON text must be UTF-8, but names can be any bytes, so they are stored as numbers.
        Json names = Json::array();
        for (const std::string& name : each.names) names.push_back(std::vector<std::uint8_t>(name.begin(), name.end()));
        json.push_back({{"kind", static_cast<int>(each.kind)}, {"ranks", each.ranks}, {"names", names}});
    }
    return json;
}

std::vector<RecordedMatte> mattes_of(const Json& json) {
    std::vector<RecordedMatte> mattes;
    for (const Json& each : json) {
        const int kind = whole(each.at("kind")), ranks = whole(each.at("ranks"));
        if (kind < 0 || kind > static_cast<int>(geoaovs::MatteKind::asset) || ranks < 2 || ranks % 2 != 0 ||
            ranks > geoaovs::Cryptomatte::most_ranks)
            throw std::runtime_error("no set of mattes");
        RecordedMatte& matte = mattes.emplace_back();
        matte.kind = static_cast<geoaovs::MatteKind>(kind);
        matte.ranks = ranks;
        for (const Json& name : each.at("names")) {
            const auto bytes = name.get<std::vector<std::uint8_t>>();
            matte.names.emplace_back(bytes.begin(), bytes.end());
        }
    }
    return mattes;
}

}  // namespace

static void visit_fields(auto visit, Parameter& parameter) {
    visit("name", parameter.name);
    visit("type", TypeNumber{parameter.type});
    visit("numbers", parameter.numbers);
    visit("strings", parameter.strings);
    visit("booleans", parameter.booleans);
}

static void visit_fields(auto visit, ObjectRequest& filter) {
    visit("name", filter.name);
    visit("parameters", filter.parameters.parameters);
}

static RAYLEX_JSON_FIELDS(display::PartitionDeclaration, name, of, layers)

    Json image_json(const RecordedImage& image) {
    const display::ImageDescription& description = image.description;
    const display::Chromaticities& c = description.chromaticities;
    Json json{{"beauty", image.beauty},
              {"attributes", description.attributes},
              {"partitions", description.partitions},
              {"chromaticities", {point_json(c.red), point_json(c.green), point_json(c.blue), point_json(c.white)}},
              {"world_to_camera", description.world_to_camera},
              {"world_to_screen", description.world_to_screen},
              {"storage", storage_json(description.storage)},
              {"single_part", description.single_part},
              {"mattes", mattes_json(image.mattes)},
              {"filters", image.filters}};
    if (const auto& window = description.data_window)
        json["data_window"] = Json::array({window->x0, window->y0, window->x1, window->y1});
    return json;
}

RecordedImage image_of(const Json& json) {
    RecordedImage image;
    display::ImageDescription& description = image.description;
    image.beauty = whole(json.at("beauty"));
    description.attributes = json.at("attributes").get<std::map<std::string, std::string>>();
    const FieldReader fields(json);
    fields("partitions", description.partitions);
    display::Chromaticities& c = description.chromaticities;
    const auto colors = json.at("chromaticities").get<std::array<std::array<double, 2>, 4>>();
    c = {colors[0], colors[1], colors[2], colors[3]};
    json.at("world_to_camera").get_to(description.world_to_camera);
    json.at("world_to_screen").get_to(description.world_to_screen);
    // Records of earlier versions lack these members.
    if (json.contains("storage")) description.storage = storage_of(json["storage"]);
    description.single_part = json.value("single_part", false);
    if (json.contains("data_window")) {
        const auto window = json["data_window"].get<std::array<int, 4>>();
        description.data_window = display::PixelRegion{window[0], window[1], window[2], window[3]};
    }
    if (json.contains("mattes")) image.mattes = mattes_of(json["mattes"]);
    fields.optional("filters", image.filters, true);
    return image;
}

}  // namespace raylex::experiments
