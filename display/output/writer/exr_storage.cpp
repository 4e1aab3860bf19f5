#include "display/output/writer/exr_storage.h"

#include <charconv>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "display/output/color/primaries.h"

namespace raylex::display {

namespace {

constexpr std::array<const char*, channel_kind_count> kind_names{"light", "color", "normal", "position", "value", "id"};
constexpr std::array<std::pair<const char*, ExrCompression>, 7> compressions{{{"none", ExrCompression::none},
                                                                              {"rle", ExrCompression::rle},
                                                                              {"zips", ExrCompression::zips},
                                                                              {"zip", ExrCompression::zip},
                                                                              {"piz", ExrCompression::piz},
                                                                              {"dwaa", ExrCompression::dwaa},
                                                                              {"dwab", ExrCompression::dwab}}};
constexpr const char* expected_words = "half or float, and one of none, rle, zips, zip, piz, dwaa, dwab";
constexpr double largest_level = 100000;

bool may_be_lossy(ChannelKind kind) {
    return kind == ChannelKind::light || kind == ChannelKind::color;
}

bool may_be_half(ChannelKind kind) {
    return kind == ChannelKind::light || kind == ChannelKind::color || kind == ChannelKind::normal;
}

const char* type_name(StoredType type) {
    switch (type) {
        case StoredType::half_float:
            return "half";
        case StoredType::single_float:
            return "float";
        case StoredType::unsigned_int:
            return "uint";
    }
    return "";
}

/// The type "half", "float" or "uint"; nothing if the word is none of them.
std::optional<StoredType> type_named(const std::string& word) {
    for (const StoredType type : {StoredType::half_float, StoredType::single_float, StoredType::unsigned_int})
        if (word == type_name(type)) return type;
    return std::nullopt;
}

Status set_type(ExrStorage& row, ChannelKind kind, bool all, StoredType type, const SourceLocation& where) {
    const bool integer = kind == ChannelKind::id;
    const bool fits =
        type == StoredType::half_float ? may_be_half(kind) : integer == (type == StoredType::unsigned_int);
    if (fits) row.type = type;
    if (fits || all) return success();
    return error_at(where, std::string("channels of kind ") + kind_name(kind) + " cannot be stored as " +
                               type_name(type) + "; expected " +
                               (integer             ? "uint"
                                : may_be_half(kind) ? "float or half"
                                                    : "float"));
}

/// Parses "zip", or "dwaa:LEVEL".
Status set_compression(ExrStorage& row, ChannelKind kind, bool all, const std::string& word,
                       const SourceLocation& where) {
    const std::size_t colon = word.find(':');
    const std::string name = word.substr(0, colon);
    std::vector<std::string> known{"half", "float", "uint"};
    for (const auto& [spelling, compression] : compressions) {
        known.emplace_back(spelling);
        if (name != spelling) continue;
        float level = ExrStorage().level;
        if (colon != std::string::npos) {
            const char* end = word.data() + word.size();
            const auto [stop, failed] = std::from_chars(word.data() + colon + 1, end, level);
            if (!is_lossy(compression) || failed != std::errc() || stop != end ||
                !(level >= 0 && level <= largest_level))
                return error_at(where, "'" + word +
                                           "' has an invalid level; expected dwaa:LEVEL or dwab:LEVEL from 0 to " +
                                           "100000, such as dwaa:45");
        }
        if (is_lossy(compression) && !may_be_lossy(kind)) {
            if (all) return success();
            return error_at(where, "compression '" + name + "' loses bits, which channels of kind " + kind_name(kind) +
                                       " must not; expected none, rle, zips, zip or piz");
        }
        row.compression = compression;
        row.level = level;
        return success();
    }
    for (const char* lossy : {"pxr24", "b44", "b44a"})
        if (name == lossy)
            return error_at(where,
                            "compression '" + name +
                                "' loses bits, so that splits would not sum; expected none, rle, zips, zip or piz, or "
                                "dwaa or dwab, whose loss `raylex verify` takes into account");
    return error_at(where, "'" + word + "' is not a storage; expected " + expected_words, near_miss(name, known));
}

Status override_row(ExrStorage& row, ChannelKind kind, bool all, const std::string& text, const SourceLocation& where) {
    std::istringstream words(text);
    bool any = false;
    for (std::string word; words >> word; any = true) {
        const std::optional<StoredType> type = type_named(word);
        Status set = type ? set_type(row, kind, all, *type, where) : set_compression(row, kind, all, word, where);
        if (!set) return set;
    }
    if (any) return success();
    return error_at(where, std::string("the storage of ") + kind_name(kind) + " is empty; expected " + expected_words);
}

}  // namespace

ExrStorageTable default_exr_storage() {
    ExrStorageTable table;
    table[static_cast<std::size_t>(ChannelKind::id)] = {StoredType::unsigned_int, ExrCompression::zips};
    return table;
}

const std::vector<ExrPreset>& exr_presets() {
    // Nuke reads single lines, in several threads, if part 0 packs single lines; then all parts must do so.
    static const std::vector<ExrPreset> presets{{"nuke", {{"all", "zips"}, {"light", "half"}}},
                                                {"blender", {{"light", "half"}, {"color", "half"}, {"normal", "half"}}},
                                                {"archive", {}}};
    return presets;
}

Status use_exr_preset(ExrStorageTable& table, const std::string& name, const SourceLocation& where) {
    std::vector<std::string> known;
    for (const ExrPreset& preset : exr_presets()) {
        known.emplace_back(preset.name);
        if (name != preset.name) continue;
        table = default_exr_storage();
        for (const auto& [kind, text] : preset.changes)
            if (Status set = override_exr_storage(table, kind, text, where); !set) return set;
        return success();
    }
    return error_at(where, "unknown preset of storage '" + name + "'; expected nuke, blender or archive",
                    near_miss(name, known));
}

ChannelKind kind_of(const ChannelDefinition& channel) {
    if (channel.style == ChannelStyle::expression) return ChannelKind::light;
    // Half floats would lose small variances, and the difference of the images of even and odd samples.
    if (channel.statistic != Statistic::none) return ChannelKind::value;
    switch (channel.type) {
        case ChannelType::integer:
            return ChannelKind::id;
        case ChannelType::real:
            return ChannelKind::value;
        case ChannelType::rgb:
            return ChannelKind::color;
        case ChannelType::normal:
            return ChannelKind::normal;
        case ChannelType::point:
        case ChannelType::vector:
            return ChannelKind::position;
    }
    return ChannelKind::value;
}

const char* kind_name(ChannelKind kind) {
    return kind_names[static_cast<std::size_t>(kind)];
}

std::string storage_text(const ExrStorage& storage) {
    std::string text = type_name(storage.type);
    for (const auto& [spelling, compression] : compressions)
        if (compression == storage.compression) text += std::string(" ") + spelling;
    if (!is_lossy(storage.compression)) return text;
    std::ostringstream level;
    level << ':' << storage.level;
    return text + level.str();
}

Status override_exr_storage(ExrStorageTable& table, const std::string& kind, const std::string& text,
                            const SourceLocation& where) {
    bool any = false;
    for (std::size_t i = 0; i < channel_kind_count; ++i) {
        if (kind != "all" && kind != kind_names[i]) continue;
        any = true;
        if (Status status = override_row(table[i], static_cast<ChannelKind>(i), kind == "all", text, where); !status)
            return status;
    }
    if (any) return success();
    std::vector<std::string> known(kind_names.begin(), kind_names.end());
    known.emplace_back("all");
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    return error_at(where, "unknown kind of channel '" + kind + "'; expected one of: " + list, near_miss(kind, known));
}

std::string color_interop_id(const Chromaticities& primaries) {
    const std::array<std::pair<Chromaticities, const char*>, 6> known{{{rec709_primaries(), "lin_rec709_scene"},
                                                                       {p3d65_primaries(), "lin_p3d65_scene"},
                                                                       {rec2020_primaries(), "lin_rec2020_scene"},
                                                                       {adobe_rgb_primaries(), "lin_adobergb_scene"},
                                                                       {aces_ap0_primaries(), "lin_ap0_scene"},
                                                                       {aces_ap1_primaries(), "lin_ap1_scene"}}};
    for (const auto& [space, id] : known)
        if (equivalent(space, primaries)) return id;
    return "unknown";
}

}  // namespace raylex::display
