#include "tests/stability/search/shrink.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <vector>

#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

using Lines = std::vector<std::string>;

Lines lines_of(const std::string& text) {
    Lines lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
        if (!line.empty() && line.front() != '#') lines.push_back(line);
    return lines;
}

std::string text_of(const Lines& lines) {
    std::string text;
    for (const std::string& line : lines) (text += line) += '\n';
    return text;
}

bool opens(const std::string& line) {
    return line == "AttributeBegin" || line.starts_with("ObjectBegin");
}
bool closes(const std::string& line) {
    return line == "AttributeEnd" || line == "ObjectEnd";
}

/// Returns the index after the last line of the block that line `at` opens.
std::size_t end_of_block(const Lines& lines, std::size_t at) {
    std::size_t depth = 0;
    for (std::size_t i = at; i < lines.size(); ++i) {
        if (opens(lines[i])) ++depth;
        if (closes(lines[i]) && --depth == 0) return i + 1;
    }
    return at + 1;
}

/// Splits a line at blanks. A string is one piece; a bracket is one piece.
std::vector<std::string> pieces_of(const std::string& line) {
    std::vector<std::string> pieces;
    for (std::size_t i = 0; i < line.size();) {
        if (line[i] == ' ') {
            ++i;
            continue;
        }
        std::size_t stop = i + 1;
        if (line[i] == '"') {
            while (stop < line.size() && line[stop] != '"') stop += line[stop] == '\\' ? 2 : 1;
            stop = std::min(stop + 1, line.size());
        } else if (line[i] != '[' && line[i] != ']') {
            while (stop < line.size() && line[stop] != ' ' && line[stop] != ']') ++stop;
        }
        pieces.push_back(line.substr(i, stop - i));
        i = stop;
    }
    return pieces;
}

std::string line_of(const std::vector<std::string>& pieces) {
    std::string line;
    for (const std::string& piece : pieces) line += (line.empty() ? "" : " ") + piece;
    return line;
}

bool is_declaration(const std::string& piece) {
    return piece.size() > 2 && piece.front() == '"' && piece.find(' ') != std::string::npos;
}

/// Returns the index after the values of the parameter that piece `at` declares.
std::size_t end_of_values(const std::vector<std::string>& pieces, std::size_t at) {
    if (at + 1 >= pieces.size() || pieces[at + 1] != "[") return std::min(at + 2, pieces.size());
    std::size_t stop = at + 1;
    while (stop < pieces.size() && pieces[stop] != "]") ++stop;
    return std::min(stop + 1, pieces.size());
}

/// Returns simpler numbers to try, the simplest first.
std::vector<std::string> simpler(const std::string& piece) {
    double value = 0;
    const auto read = std::from_chars(piece.data(), piece.data() + piece.size(), value);
    if (read.ec != std::errc() || read.ptr != piece.data() + piece.size()) return {};
    std::vector<std::string> tries;
    const auto offer = [&](double v) {
        std::array<char, 40> text{};
        const auto end = std::to_chars(text.data(), text.data() + text.size(), v);
        const std::string written(text.data(), end.ptr);
        if (written.size() < piece.size() || (v != value && std::abs(v) < 2 && written.size() <= piece.size()))
            if (written != piece && (tries.empty() || tries.back() != written)) tries.push_back(written);
    };
    if (value == 0) return {};
    offer(0);
    if (value == 1) return tries;
    offer(value < 0 ? -1 : 1);
    offer(std::trunc(value));
    for (const int digits : {1, 2, 4}) {
        std::array<char, 40> text{};
        std::snprintf(text.data(), text.size(), "%.*g", digits, value);
        offer(std::strtod(text.data(), nullptr));
    }
    return tries;
}

class Shrinker {
  public:
    Shrinker(const std::string& text, const std::function<bool(const std::string&)>& fails, const ShrinkLimits& limits)
        : lines_(lines_of(text)), fails_(fails), limits_(limits) {}

    Shrunk run() {
        for (bool smaller = true; smaller && !spent();) {
            smaller = chunks();
            smaller = blocks() || smaller;
            smaller = parameters() || smaller;
            smaller = faces() || smaller;
            if (!smaller) smaller = numbers();
        }
        return {text_of(lines_), trials_};
    }

  private:
    [[nodiscard]] bool spent() const { return trials_ >= limits_.most_trials || watch_.wall() > limits_.seconds; }

    bool accept(Lines candidate) {
        if (spent() || candidate == lines_) return false;
        ++trials_;
        if (!fails_(text_of(candidate))) return false;
        lines_ = std::move(candidate);
        return true;
    }
    [[nodiscard]] Lines without(std::size_t first, std::size_t end) const {
        Lines rest(lines_.begin(), lines_.begin() + static_cast<std::ptrdiff_t>(first));
        rest.insert(rest.end(), lines_.begin() + static_cast<std::ptrdiff_t>(std::min(end, lines_.size())),
                    lines_.end());
        return rest;
    }
    [[nodiscard]] bool balanced(std::size_t first, std::size_t end) const {
        int depth = 0;
        for (std::size_t i = first; i < std::min(end, lines_.size()); ++i) {
            depth += opens(lines_[i]) ? 1 : closes(lines_[i]) ? -1 : 0;
            if (depth < 0) return false;
        }
        return depth == 0;
    }

    bool chunks() {
        bool any = false;
        for (std::size_t size = std::max<std::size_t>(lines_.size() / 2, 1); size > 0; size /= 2)
            for (std::size_t at = lines_.size(); at > 0 && !spent();) {
                const std::size_t first = at > size ? at - size : 0;
                if (balanced(first, at) && accept(without(first, at))) any = true;
                at = std::min(first, lines_.size());
            }
        return any;
    }
    bool blocks() {
        bool any = false;
        for (std::size_t i = lines_.size(); i-- > 0;) {
            if (i >= lines_.size() || !opens(lines_[i])) continue;
            const std::size_t end = end_of_block(lines_, i);
            if (accept(without(i, end))) {
                any = true;
                continue;
            }
            Lines unwrapped = without(end - 1, end);
            unwrapped.erase(unwrapped.begin() + static_cast<std::ptrdiff_t>(i));
            any = accept(std::move(unwrapped)) || any;
        }
        return any;
    }
    bool replace(std::size_t line, const std::vector<std::string>& pieces) {
        Lines candidate = lines_;
        candidate[line] = line_of(pieces);
        return accept(std::move(candidate));
    }
    bool parameters() {
        bool any = false;
        for (std::size_t line = 0; line < lines_.size() && !spent(); ++line) {
            std::vector<std::string> pieces = pieces_of(lines_[line]);
            for (std::size_t i = pieces.size(); i-- > 1;) {
                if (i >= pieces.size() || !is_declaration(pieces[i])) continue;
                std::vector<std::string> fewer = pieces;
                fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i),
                            fewer.begin() + static_cast<std::ptrdiff_t>(end_of_values(pieces, i)));
                if (!replace(line, fewer)) continue;
                pieces = std::move(fewer);
                any = true;
            }
        }
        return any;
    }
    /// Removes unnecessary faces of meshes. Other faces and per-vertex values stay.
    bool faces() {
        bool any = false;
        for (std::size_t line = 0; line < lines_.size() && !spent(); ++line) {
            const std::size_t group = lines_[line].starts_with("Shape \"trianglemesh\"")   ? 3
                                      : lines_[line].starts_with("Shape \"bilinearmesh\"") ? 4
                                                                                           : 0;
            if (group == 0) continue;
            std::vector<std::string> pieces = pieces_of(lines_[line]);
            const auto found = std::find(pieces.begin(), pieces.end(), "\"integer indices\"");
            if (found == pieces.end()) continue;
            const auto first = static_cast<std::size_t>(found - pieces.begin()) + 2;
            for (std::size_t end = end_of_values(pieces, first - 2) - 1; end >= first + 2 * group; end -= group) {
                std::vector<std::string> fewer = pieces;
                fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(end - group),
                            fewer.begin() + static_cast<std::ptrdiff_t>(end));
                if (!replace(line, fewer)) continue;
                pieces = std::move(fewer);
                any = true;
            }
        }
        return any;
    }
    bool numbers() {
        bool any = false;
        for (std::size_t line = 0; line < lines_.size() && !spent(); ++line) {
            std::vector<std::string> pieces = pieces_of(lines_[line]);
            for (std::size_t i = 1; i < pieces.size() && !spent(); ++i)
                for (const std::string& other : simpler(pieces[i])) {
                    std::vector<std::string> candidate = pieces;
                    candidate[i] = other;
                    if (!replace(line, candidate)) continue;
                    pieces = std::move(candidate);
                    any = true;
                    break;
                }
        }
        return any;
    }

    Lines lines_;
    const std::function<bool(const std::string&)>& fails_;
    ShrinkLimits limits_;
    std::size_t trials_ = 0;
    transport::Stopwatch watch_;
};

}  // namespace

Shrunk shrink_scene(const std::string& text, const std::function<bool(const std::string&)>& fails,
                    const ShrinkLimits& limits) {
    return Shrinker(text, fails, limits).run();
}

}  // namespace raylex::experiments
