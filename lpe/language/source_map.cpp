#include "lpe/language/source_map.h"

#include <algorithm>

namespace raylex::lpe {

namespace {

constexpr std::size_t longest_excerpt = 4'096;  // bytes; a longer line is of no use in a terminal

}  // namespace

TextPlace place_of(const TextFile& file, std::size_t position) {
    const std::string& text = file.text;
    position = std::min(position, text.size());
    const std::size_t before = position == 0 ? std::string::npos : text.rfind('\n', position - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    TextPlace place;
    place.line =
        1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
    if (!file.numbered && text.find('\n') == std::string::npos) { place.line = 0; }
    place.column = static_cast<int>(position - begin) + 1;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin <= longest_excerpt) { place.line_text = text.substr(begin, end - begin); }
    if (!place.line_text.empty() && place.line_text.back() == '\r') { place.line_text.pop_back(); }
    return place;
}

const SourceMap::Span& SourceMap::span_at(std::size_t offset) const {
    const auto after = std::upper_bound(spans.begin(), spans.end(), offset,
                                        [](std::size_t at, const Span& span) { return at < span.offset; });
    return after == spans.begin() ? spans.front() : *(after - 1);
}

}  // namespace raylex::lpe
