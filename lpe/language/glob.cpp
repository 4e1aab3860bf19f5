#include "lpe/language/glob.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>

#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

enum class Piece { byte, one, many };

struct GlobStep {
    Piece piece;
    char byte;
};

std::vector<GlobStep> read_glob(std::string_view glob) {
    std::vector<GlobStep> steps;
    for (std::size_t i = 0; i < glob.size(); ++i) {
        if (glob[i] == '*') {
            steps.push_back({Piece::many, 0});
        } else if (glob[i] == '?') {
            steps.push_back({Piece::one, 0});
        } else {
            if (glob[i] == '\\' && i + 1 < glob.size()) { ++i; }
            steps.push_back({Piece::byte, glob[i]});
        }
    }
    return steps;
}

std::vector<GlobStep> read_name(std::string_view name) {
    std::vector<GlobStep> steps;
    for (const char byte : name) { steps.push_back({Piece::byte, byte}); }
    return steps;
}

bool is_continuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

// Positions in `steps`, ascending; positions after a '*' that matches nothing are included.
using Positions = std::vector<std::size_t>;

void add_position(Positions& positions, const std::vector<GlobStep>& steps, std::size_t position) {
    for (;; ++position) {
        if (std::find(positions.begin(), positions.end(), position) == positions.end()) {
            positions.push_back(position);
        }
        if (position >= steps.size() || steps[position].piece != Piece::many) { return; }
    }
}

/// Keeps the last '*' that is reached, and later positions. Anything that can follow an earlier position can also
/// follow that '*', so a glob with many '*' keeps few positions.
void keep_from_last_star(Positions& positions, const std::vector<GlobStep>& steps) {
    std::sort(positions.begin(), positions.end());
    for (std::size_t i = positions.size(); i-- > 0;) {
        if (positions[i] < steps.size() && steps[positions[i]].piece == Piece::many) {
            positions.erase(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(i));
            return;
        }
    }
}

Positions advance(const std::vector<GlobStep>& steps, const Positions& positions, char byte) {
    Positions next;
    for (const std::size_t position : positions) {
        if (position > 0 && steps[position - 1].piece == Piece::one && is_continuation(byte)) {
            add_position(next, steps, position);  // the remaining bytes of the character that '?' matches
        }
        if (position >= steps.size()) { continue; }
        const GlobStep& step = steps[position];
        if (step.piece == Piece::many) {
            add_position(next, steps, position);
        } else if (step.piece == Piece::one ? !is_continuation(byte) : step.byte == byte) {
            add_position(next, steps, position + 1);
        }
    }
    keep_from_last_star(next, steps);
    return next;
}

Positions start_positions(const std::vector<GlobStep>& steps) {
    Positions positions;
    add_position(positions, steps, 0);
    keep_from_last_star(positions, steps);
    return positions;
}

bool accepts(const std::vector<GlobStep>& steps, const Positions& positions) {
    return std::find(positions.begin(), positions.end(), steps.size()) != positions.end();
}

/// The bytes that the steps name, and one ordinary character that represents all others.
std::vector<char> distinguished_bytes(const std::vector<std::vector<GlobStep>>& all) {
    std::set<char> bytes;
    for (const auto& steps : all) {
        for (const GlobStep& step : steps) {
            if (step.piece == Piece::byte) { bytes.insert(step.byte); }
        }
    }
    std::vector<char> alphabet(bytes.begin(), bytes.end());
    for (int candidate = 0; candidate < 127; ++candidate) {
        const char byte = static_cast<char>(candidate < 26 ? 'a' + candidate : candidate == 26 ? 'A' : candidate);
        if ((candidate <= 26 || candidate >= 33) && bytes.count(byte) == 0) {
            alphabet.insert(alphabet.begin(), byte);
            break;
        }
    }
    return alphabet;
}

}  // namespace

bool glob_matches(std::string_view glob, std::string_view label) {
    const std::vector<GlobStep> steps = read_glob(glob);
    Positions positions = start_positions(steps);
    for (const char byte : label) { positions = advance(steps, positions, byte); }
    return accepts(steps, positions);
}

std::string quoted_label(std::string_view label) {
    std::string text = "'";
    for (const char c : label) {
        if (c == '\'' || c == '\\' || c == '*' || c == '?') { text += '\\'; }
        text += c;
    }
    return text + "'";
}

bool is_glob(std::string_view text) {
    return text.find_first_of("*?\\") != std::string_view::npos;
}

std::vector<LabelKind> label_kinds(const std::vector<std::string>& globs, const std::vector<std::string>& names) {
    std::vector<std::vector<GlobStep>> all;
    for (const std::string& glob : globs) { all.push_back(read_glob(glob)); }
    for (const std::string& name : names) { all.push_back(read_name(name)); }
    using Joint = std::vector<Positions>;
    const std::vector<char> alphabet = distinguished_bytes(all);
    std::map<Joint, std::size_t> seen;
    std::vector<std::pair<const Joint*, std::string>> queue;
    std::set<std::vector<bool>> found;
    std::vector<LabelKind> kinds;
    std::size_t work = 0;
    const auto reach = [&](Joint joint, std::string label) {
        const auto [place, fresh] = seen.emplace(std::move(joint), queue.size());
        if (!fresh) { return; }
        work += label.size() + all.size();
        if (queue.size() > limits::glob_states || work > limits::label_tests) {
            fail("the label globs combine to more than " + std::to_string(limits::glob_states) + " cases",
                 "use fewer '*' and '?' on one label slot");
        }
        queue.emplace_back(&place->first, label);
        for (std::size_t i = globs.size(); i < all.size(); ++i) {
            if (accepts(all[i], place->first[i])) {
                return;  // a label in `names`
            }
        }
        std::vector<bool> matched(globs.size());
        for (std::size_t i = 0; i < globs.size(); ++i) { matched[i] = accepts(all[i], place->first[i]); }
        if (found.insert(matched).second) { kinds.push_back({std::move(matched), std::move(label)}); }
    };
    Joint start;
    for (const auto& steps : all) { start.push_back(start_positions(steps)); }
    reach(std::move(start), {});
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const Joint* from = queue[i].first;
        const std::string label = queue[i].second;
        for (const char byte : alphabet) {
            Joint joint;
            for (std::size_t k = 0; k < all.size(); ++k) { joint.push_back(advance(all[k], (*from)[k], byte)); }
            reach(std::move(joint), label + byte);
        }
    }
    return kinds;
}

}  // namespace raylex::lpe
