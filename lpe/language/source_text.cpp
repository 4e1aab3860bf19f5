#include "lpe/language/source_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "lpe/failure.h"
#include "lpe/language/source_map.h"

namespace raylex::lpe {

namespace {

struct LookAlike {
    std::uint32_t code_point;
    char meant;
    std::string_view script;
};

// Letters of other scripts that look like event letters, and marks that word processors insert.
// Source: Unicode confusables (UTS #39), the rows for the letters of this language.
constexpr std::array look_alikes{
    LookAlike{0x0421, 'C', "Cyrillic"}, LookAlike{0x0412, 'B', "Cyrillic"}, LookAlike{0x041E, 'O', "Cyrillic"},
    LookAlike{0x0405, 'S', "Cyrillic"}, LookAlike{0x0422, 'T', "Cyrillic"}, LookAlike{0x0455, 's', "Cyrillic"},
    LookAlike{0x0474, 'V', "Cyrillic"}, LookAlike{0x050C, 'G', "Cyrillic"}, LookAlike{0x0392, 'B', "Greek"},
    LookAlike{0x039F, 'O', "Greek"},    LookAlike{0x03A4, 'T', "Greek"},    LookAlike{0x03F9, 'C', "Greek"},
    LookAlike{0x2018, '\'', ""},        LookAlike{0x2019, '\'', ""},        LookAlike{0x201C, '\'', ""},
    LookAlike{0x201D, '\'', ""},        LookAlike{0x2032, '\'', ""},        LookAlike{0x2212, '-', ""},
    LookAlike{0x2013, '-', ""},         LookAlike{0x2014, '-', ""},         LookAlike{0x2217, '*', ""},
    LookAlike{0x2223, '|', ""},         LookAlike{0x2329, '<', ""},         LookAlike{0x232A, '>', ""},
    LookAlike{0x27E8, '<', ""},         LookAlike{0x27E9, '>', ""},         LookAlike{0x2039, '<', ""},
    LookAlike{0x203A, '>', ""},         LookAlike{0x3008, '<', ""},         LookAlike{0x3009, '>', ""},
};

struct Character {
    std::uint32_t code_point = 0;
    std::size_t bytes = 1;
    bool valid = true;
};

Character decode(std::string_view text, std::size_t offset) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
    const std::uint32_t lead = byte(offset);
    if (lead < 0x80) { return {lead, 1, true}; }
    const std::size_t length = lead >= 0xF0 && lead < 0xF8 ? 4 : lead >= 0xE0 && lead < 0xF0 ? 3 : lead >= 0xC0 ? 2 : 1;
    if (length == 1 || lead >= 0xF8 || offset + length > text.size()) { return {lead, 1, false}; }
    std::uint32_t code_point = lead & (0xFFU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(offset + i) & 0xC0U) != 0x80U) { return {lead, 1, false}; }
        code_point = code_point << 6 | (byte(offset + i) & 0x3FU);
    }
    return {code_point, length, true};
}

std::string hexadecimal(const char* format, std::uint32_t value) {
    std::array<char, 24> buffer{};
    const int length = std::snprintf(buffer.data(), buffer.size(), format, value);
    return {buffer.data(), static_cast<std::size_t>(length)};
}

Error mapped_error(const SourceMap& map, std::size_t offset, std::string message, std::string hint) {
    const SourceMap::Span& span = map.span_at(offset);
    const TextPlace place = place_of(*span.file, span.position + (offset - span.offset));
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    if (!span.via.empty()) { error.hint += (error.hint.empty() ? "" : "\n") + span.via; }
    error.file = span.file->name;
    error.line = place.line;
    error.column = place.column;
    error.excerpt = place.line_text;
    return error;
}

}  // namespace

void SourceText::fail_at(std::size_t offset, std::string message, std::string hint) const {
    const std::string& text = source_->expression;
    offset = std::min(offset, text.size());
    if (source_->map && !source_->map->spans.empty()) {
        throw Failure{mapped_error(*source_->map, offset, std::move(message), std::move(hint))};
    }
    const std::size_t before = text.rfind('\n', offset == 0 ? std::string::npos : offset - 1);
    const std::size_t begin = offset == 0 || before == std::string::npos ? 0 : before + 1;
    const int lines_down =
        static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    error.file =
        source_->origin.empty() && !source_->name.empty() ? "channel '" + source_->name + "'" : source_->origin;
    error.excerpt = text.substr(begin, text.find('\n', begin) - begin);
    error.column = static_cast<int>(offset - begin) + 1;
    if (source_->origin_line > 0) {
        error.line = source_->origin_line + lines_down;
    } else if (text.find('\n') != std::string::npos) {
        error.line = lines_down + 1;
    }
    if (lines_down == 0 && source_->origin_column > 1) {
        // Columns count from the start of the file's line; the text before the expression is not available here.
        error.column += source_->origin_column - 1;
        error.excerpt.insert(0, static_cast<std::size_t>(source_->origin_column - 1), ' ');
    }
    throw Failure{std::move(error)};
}

Error SourceText::whole_error(const ChannelSource& source, Error error) {
    if (error.file.empty()) {
        error.file = source.origin.empty() && !source.name.empty() ? "channel '" + source.name + "'" : source.origin;
        error.line = source.origin_line;
        error.column = source.origin_line > 0 ? source.origin_column : 0;
    }
    return error;
}

std::string SourceText::describe(std::size_t offset) const {
    if (offset >= size()) { return "the end of the expression"; }
    const Character character = decode(text(), offset);
    if (!character.valid || character.code_point < 0x20 || character.code_point == 0x7F) {
        if (text()[offset] == '\n') { return "the end of the line"; }
        return hexadecimal("the byte 0x%02X", character.code_point);
    }
    std::string shown(1, '\'');
    shown += text().substr(offset, character.bytes);
    shown += '\'';
    if (character.code_point >= 0x80) { shown += hexadecimal(" (U+%04X)", character.code_point); }
    return shown;
}

std::string SourceText::look_alike_hint(std::size_t offset) const {
    if (offset >= size()) { return {}; }
    const Character character = decode(text(), offset);
    if (character.valid && character.code_point >= 0xFF01 && character.code_point <= 0xFF5E) {
        return "this is a full-width character; did you mean '" +
               std::string(1, static_cast<char>(character.code_point - 0xFF01 + 0x21)) + "'?";
    }
    for (const LookAlike& entry : look_alikes) {
        if (character.valid && entry.code_point == character.code_point) {
            const std::string kind = entry.script.empty() ? "typographic mark" : std::string(entry.script) + " letter";
            return "this is a " + kind + " that looks like '" + std::string(1, entry.meant) + "'; did you mean '" +
                   std::string(1, entry.meant) + "'?";
        }
    }
    return {};
}

std::string nearest(std::string_view word, const std::string_view* candidates, std::size_t count) {
    std::string_view best;
    std::size_t best_distance = word.size() < 4 ? 2 : 3;
    for (std::size_t k = 0; k < count; ++k) {
        const std::string_view candidate = candidates[k];
        // Levenshtein distance, computed row by row.
        std::vector<std::size_t> row(candidate.size() + 1);
        for (std::size_t j = 0; j < row.size(); ++j) { row[j] = j; }
        for (std::size_t i = 0; i < word.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 1; j < row.size(); ++j) {
                const std::size_t above = row[j];
                const std::size_t substituted = diagonal + (word[i] == candidate[j - 1] ? 0U : 1U);
                row[j] = std::min({above + 1, row[j - 1] + 1, substituted});
                diagonal = above;
            }
        }
        if (row.back() < best_distance) {
            best_distance = row.back();
            best = candidate;
        }
    }
    return std::string(best);
}

}  // namespace raylex::lpe
