#include "display/output/exr_storage.h"

#include <sstream>
#include <utility>
#include <vector>

#include "display/output/primaries.h"

namespace raylex::display {

namespace {

constexpr std::array<const char*, channel_kind_count> kind_names{"light", "color", "normal", "position", "value", "id"};
constexpr std::array<std::pair<const char*, ExrCompression>, 5> compressions{
    {{"none", ExrCompression::none},
     {"rle", ExrCompression::rle},
     {"zips", ExrCompression::zips},
     {"zip", ExrCompression::zip},
     {"piz", ExrCompression::piz}}};

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

std::string near_hint(const std::string& word, const std::vector<std::string>& known) {
    const std::string near = nearest_name(word, known);
    return near.empty() ? std::string() : "did you mean '" + near + "'?";
}

Status override_row(ExrStorage& row, ChannelKind kind, bool all, const std::string& text, const SourceLocation& where) {
    const std::string name = kind_name(kind);
    std::istringstream words(text);
    bool any = false;
    for (std::string word; words >> word; any = true) {
        if (word == "half" || word == "float" || word == "uint") {
            const StoredType type = word == "half"    ? StoredType::half_float
                                    : word == "float" ? StoredType::single_float
                                                      : StoredType::unsigned_int;
            const bool integer = kind == ChannelKind::id;
            const bool fits = type == StoredType::half_float ? may_be_half(kind)
                                                             : integer == (type == StoredType::unsigned_int);
            if (fits) row.type = type;
            else if (!all)
                return error_at(where, "channels of kind " + name + " cannot be stored as " + word + "; expected " +
                                           (integer ? "uint" : may_be_half(kind) ? "float or half" : "float"));
            continue;
        }
        bool found = false;
        std::vector<std::string> known{"half", "float", "uint"};
        for (const auto& [spelling, compression] : compressions) {
            known.emplace_back(spelling);
            if (word != spelling) continue;
            row.compression = compression;
            found = true;
        }
        if (found) continue;
        for (const char* lossy : {"pxr24", "b44", "b44a", "dwaa", "dwab"})
            if (word == lossy)
                return error_at(where, "compression '" + word +
                                           "' loses bits, so that splits would not sum; expected none, rle, zips, zip "
                                           "or piz");
        return error_at(where,
                        "'" + word +
                            "' says nothing about storage; expected half or float, and one of none, rle, zips, "
                            "zip, piz",
                        near_hint(word, known));
    }
    if (!any)
        return error_at(where, "nothing is said about the storage of " + name +
                                   "; expected half or float, and one of none, rle, zips, zip, piz");
    return success();
}

}  // namespace

ExrStorageTable default_exr_storage() {
    ExrStorageTable table;
    table[static_cast<std::size_t>(ChannelKind::id)] = {StoredType::unsigned_int, ExrCompression::zips};
    return table;
}

ChannelKind kind_of(const ChannelDefinition& channel) {
    if (channel.style == ChannelStyle::expression) return ChannelKind::light;
    // A variance is a colour's square and no colour: halves would lose it where it is small.
    if (channel.statistic == Statistic::variance || channel.statistic == Statistic::mse) return ChannelKind::value;
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
    return text;
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
    return error_at(where, "unknown kind of channel '" + kind + "'; expected one of: " + list, near_hint(kind, known));
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
