#include "experiments/report/html.h"

#include <algorithm>

namespace raylex::experiments {

std::string escape_html(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            case '\'':
                result += "&#39;";
                break;
            default:
                result += static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t' ? ' ' : c;
        }
    }
    return result;
}

std::string base64(std::span<const unsigned char> bytes) {
    static constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    result.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned bits = static_cast<unsigned>(bytes[i]) << 16;
        if (count > 1) bits |= static_cast<unsigned>(bytes[i + 1]) << 8;
        if (count > 2) bits |= bytes[i + 2];
        result += letters[bits >> 18 & 63];
        result += letters[bits >> 12 & 63];
        result += count > 1 ? letters[bits >> 6 & 63] : '=';
        result += count > 2 ? letters[bits & 63] : '=';
    }
    return result;
}

std::string data_uri(std::span<const unsigned char> png) {
    return "data:image/png;base64," + base64(png);
}

std::string script_json(std::string_view json) {
    std::string safe;
    safe.reserve(json.size());
    for (const char c : json)
        if (c == '<') safe += "\\u003c";
        else safe += c;
    return safe;
}

}  // namespace raylex::experiments
