#include "display/output/atlas/atlas_table.h"

#include <charconv>
#include <set>
#include <string_view>

#include "display/services/parameters.h"
#include "lpe/language/prefixes.h"
#include "lpe/match.h"

namespace raylex::display {
namespace {

constexpr const char* table_version = "2";

Error damaged_table(const std::string& path, const std::string& what) {
    return error_at({path, 0, 0}, "the atlas's header is damaged: " + what +
                                      "; expected an atlas as raylex render --atlas writes it");
}

/// Reads numbers separated by blanks; `*` is PathAlphabet::open.
bool read_letters(std::string_view text, std::vector<PathStringTable::Letter>& letters) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(' '), text.size());
        const std::string_view word = text.substr(0, end);
        PathStringTable::Letter letter = PathAlphabet::open;
        if (word != "*") {
            const auto [next, failed] = std::from_chars(word.data(), word.data() + word.size(), letter);
            if (failed != std::errc() || next != word.data() + word.size() || letter == PathAlphabet::open)
                return false;
        }
        letters.push_back(letter);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return true;
}

/// Removes and parses the text after the last blank, such as "s1t3".
bool take_technique(std::string_view& line, Technique& technique) {
    const std::size_t blank = line.rfind(' ');
    if (blank == std::string_view::npos) return false;
    const auto read = lpe::technique_prefix(line.substr(blank + 1));
    if (!read || read->t == 0) return false;
    technique = {read->s, read->t};
    line = line.substr(0, blank);
    return true;
}

std::string letters_text(const std::vector<PathStringTable::Letter>& letters) {
    std::string text;
    for (const PathStringTable::Letter letter : letters) {
        if (!text.empty()) text += ' ';
        text += letter == PathAlphabet::open ? "*" : std::to_string(letter);
    }
    return text;
}

bool is_terminal(const lpe::Event& event) {
    return event.type == lpe::EventType::light || event.type == lpe::EventType::background ||
           event.type == lpe::EventType::emission;
}

/// Every word has scatterings, no other letters after the first `*`, and a terminal.
Status check_path_strings(const PathStringTable& table, const std::string& path) {
    std::set<PathStringTable::Letter> scatterings, terminals;
    for (std::size_t i = 0; i < table.events.size(); ++i)
        (is_terminal(table.events[i]) ? terminals : scatterings).insert(table.letters[i]);
    for (const std::vector<PathStringTable::Letter>& word : table.words) {
        bool good = !word.empty() && terminals.count(word.back()) > 0;
        for (std::size_t i = 0; good && i + 1 < word.size(); ++i)
            good = word[i] == PathAlphabet::open ? i + 2 == word.size() || word[i + 1] == PathAlphabet::open
                                                 : scatterings.count(word[i]) > 0;
        if (!good)
            return damaged_table(path, "'" + letters_text(word) + "' in atlas/words is not a word over its events");
    }
    return success();
}

/// Restores the labels that to_text() omits: scatterings have two slots, terminals one.
void restore_labels(lpe::Event& event) {
    event.labels.resize(is_terminal(event) ? 1 : 2);
}

}  // namespace

std::map<std::string, std::string> table_attributes(const PathStringTable& table) {
    std::map<std::string, std::string> attributes;
    attributes["atlas/version"] = table_version;
    attributes["atlas/by"] = to_string(table.rules);
    attributes["atlas/length"] = std::to_string(table.rules.length);
    attributes["atlas/events"] = lpe::to_text(table.events);
    attributes["atlas/letters"] = letters_text(table.letters);
    std::string words;
    for (std::size_t i = 0; i < table.words.size(); ++i)
        words += letters_text(table.words[i]) + (table.techniques.empty() ? "" : ' ' + to_string(table.techniques[i])) +
                 '\n';
    attributes["atlas/words"] = std::move(words);
    if (table.dropped_straight) attributes["atlas/straight"] = "dropped";
    if (table.is_signed()) attributes["atlas/signed"] = table.negative == SignedLight::light ? "light" : "weights";
    if (table.merged > 0) attributes["atlas/merged"] = std::to_string(table.merged);
    return attributes;
}

Result<PathStringTable> read_table(const std::map<std::string, std::string>& attributes, const std::string& path) {
    const auto text = [&](const char* name) {
        const auto found = attributes.find(name);
        return found == attributes.end() ? std::string() : found->second;
    };
    if (text("atlas/version") != table_version) {
        Error error;
        error.file = path;
        error.message = "this atlas is of version '" + text("atlas/version") + "'; expected version " + table_version;
        return error;
    }
    PathStringTable table;
    auto rules = parse_path_string_rules(text("atlas/by"), {path, 0, 0});
    if (!rules) return rules.error();
    table.rules = *rules;
    const std::string length = text("atlas/length");
    const char* const end_of_length = length.data() + length.size();
    if (std::from_chars(length.data(), end_of_length, table.rules.length).ptr != end_of_length ||
        table.rules.length < 0 || table.rules.length > PathStringRules::most_length)
        return damaged_table(path, "'" + length + "' in atlas/length is not a length from 0 to " +
                                       std::to_string(PathStringRules::most_length));
    auto events = lpe::parse_events(text("atlas/events"));
    if (!events) return damaged_table(path, "atlas/events cannot be parsed: " + events.error().message);
    table.events = *std::move(events);
    for (lpe::Event& event : table.events) restore_labels(event);
    if (!read_letters(text("atlas/letters"), table.letters) || table.letters.size() != table.events.size())
        return damaged_table(path, "atlas/letters does not have a number for each event");
    const std::string words = text("atlas/words");
    for (std::size_t begin = 0; begin < words.size();) {
        const std::size_t end = words.find('\n', begin);
        if (end == std::string::npos) return damaged_table(path, "atlas/words does not end with a line end");
        std::string_view line = std::string_view(words).substr(begin, end - begin);
        if ((table.rules.techniques && !take_technique(line, table.techniques.emplace_back())) ||
            !read_letters(line, table.words.emplace_back()))
            return damaged_table(path, "'" + words.substr(begin, end - begin) + "' in atlas/words is not a word");
        begin = end + 1;
    }
    table.dropped_straight = text("atlas/straight") == "dropped";
    const std::string negative = text("atlas/signed");
    if (!negative.empty()) table.negative = negative == "light" ? SignedLight::light : SignedLight::weights;
    const std::string merged = text("atlas/merged");
    if (!merged.empty()) std::from_chars(merged.data(), merged.data() + merged.size(), table.merged);
    if (Status good = check_path_strings(table, path); !good) return good.error();
    return table;
}

}  // namespace raylex::display
