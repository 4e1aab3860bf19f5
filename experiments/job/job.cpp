#include "experiments/job/job.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace raylex::experiments {

Result<lpe::Dialect> parse_dialect(const std::string& name, const SourceLocation& where) {
    if (name == "renderman") return lpe::Dialect::renderman;
    if (name == "osl") return lpe::Dialect::osl;
    return error_at(where, "unknown dialect '" + name + "'; expected renderman or osl",
                    near_miss(name, {"renderman", "osl"}));
}

void take_dialect_mark(std::string& expression, lpe::Dialect& dialect) {
    for (const auto& [mark, marked] : {std::pair<std::string_view, lpe::Dialect>{"osl:", lpe::Dialect::osl},
                                       {"renderman:", lpe::Dialect::renderman}}) {
        if (!expression.starts_with(mark)) continue;
        expression.erase(0, mark.size());
        dialect = marked;
        return;
    }
}

Result<std::array<int, 2>> parse_resolution(const std::string& text, const SourceLocation& where) {
    const std::size_t cross = text.find('x');
    std::array<int, 2> size{};
    const auto read = [](std::string_view digits, int& number) {
        const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
        return status == std::errc() && end == digits.data() + digits.size() && number >= 1 && number <= 65536;
    };
    if (cross == std::string::npos || !read(std::string_view(text).substr(0, cross), size[0]) ||
        !read(std::string_view(text).substr(cross + 1), size[1]))
        return error_at(where, "'" + text +
                                   "' is not a resolution; expected WIDTHxHEIGHT in pixels, each from 1 to 65536, "
                                   "such as 640x480");
    return size;
}

Result<display::PixelRegion> parse_crop(const std::string& text, const SourceLocation& where) {
    std::array<int, 4> corners{};
    const char* at = text.data();
    const char* const end = at + text.size();
    bool good = true;
    for (std::size_t i = 0; i < corners.size() && good; ++i) {
        const auto [next, failed] = std::from_chars(at, end, corners[i]);
        const bool last = i + 1 == corners.size();
        good = failed == std::errc() && corners[i] >= 0 && (last ? next == end : next != end && *next == ',');
        at = next + (last ? 0 : 1);
    }
    if (good && corners[0] < corners[2] && corners[1] < corners[3])
        return display::PixelRegion{corners[0], corners[1], corners[2], corners[3]};
    return error_at(where,
                    "'" + text +
                        "' is not a part of an image; expected X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1, such as "
                        "0,0,320,240");
}

Status add_cryptomatte(const std::string& name, const SourceLocation& where, transport::MatteSettings& mattes) {
    auto kind = geoaovs::parse_matte_kind(name, {});
    if (!kind) return error_at(where, kind.error().message, kind.error().hint);
    for (const geoaovs::MatteKind known : mattes.kinds)
        if (known == *kind)
            return error_at(where, "the cryptomatte '" + name + "' is requested twice; expected each kind once");
    mattes.kinds.push_back(*kind);
    return success();
}

Result<display::LayerRequest> read_layer_request(const std::string& name, const std::string& channel,
                                                 const std::string& rule, const SourceLocation& where) {
    if (Status fits = check_layer_name(name, where); !fits) return fits.error();
    auto parsed = display::parse_rule_request(channel, rule, where);
    if (!parsed) return parsed.error();
    return display::LayerRequest{name, channel, parsed->rule, where};
}

Status check_layer_name(const std::string& name, const SourceLocation& where) {
    if (name.empty()) return error_at(where, "a channel name is empty; expected a name such as caustics");
    if (name.size() > 128)
        return error_at(where,
                        "the channel name is " + std::to_string(name.size()) + " bytes long; expected at most 128");
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == ':'; };
    if (!letter(name.front()) || name.back() == '.' || !std::all_of(name.begin(), name.end(), inner))
        return error_at(where, "'" + name +
                                   "' cannot be a channel name; expected letters, digits and _ - . : beginning with "
                                   "a letter or _, and no dot at the end");
    for (const char* taken : {"CryptoObject", "CryptoMaterial", "CryptoAsset"})
        if (name.starts_with(taken))
            return error_at(where, "the channel name '" + name + "' begins like layers of the cryptomatte '" + taken +
                                       "'; expected another name");
    for (const char* taken : {"beauty", "rgba", "R", "G", "B", "A", "Y"})
        if (name == taken)
            return error_at(where,
                            "the channel name '" + name + "' is reserved for the beauty image; expected another name");
    return success();
}

Result<TechniqueRequest> parse_techniques(const std::string& text, const SourceLocation& where) {
    const std::string pyramid = "pyramid";
    TechniqueRequest request{{}, where};
    if (text == pyramid) {
        request.channels.emplace_back("beauty");
        return request;
    }
    if (!text.starts_with(pyramid + ":"))
        return error_at(where, "'" + text +
                                   "' is not a set of technique layers; expected pyramid, or pyramid: and names of "
                                   "channels separated by commas");
    for (std::size_t begin = pyramid.size() + 1; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        if (end == begin)
            return error_at(where, "'" + text + "' has an empty channel name; expected names separated by commas");
        request.channels.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return request;
}

}  // namespace raylex::experiments
