// The parser of the `osl` dialect. It agrees with Open Shading Language's parser (liboslexec/lpeparse) in every
// construct, oddities included. An event is a word of symbols: type, scatter, labels. <...> contains an expression over
// these symbols without repetitions, so each item is a finite set of fixed-length symbol sequences.
//
// Oddities that are kept because channels written for OSL depend on them:
// - a leading '(' ends the expression at its ')'; OSL ignores the rest (raylex warns);
// - inside <...> every byte that is no other token is a symbol, digits and blanks included, and it may never match;
// - a quoted '.' inside <...> is the wildcard;
// - the slot of [^...] outside <...> is that of its last symbol;
// - {n,m} with m < n repeats n times.
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "lpe/language/parser/osl_events.h"
#include "lpe/language/parser/parser.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

enum class Slot : int { type = 0, scatter = 1, label = 2, unknown = 3 };

Slot slot_of(char symbol) {
    switch (symbol) {
        case 'C':
        case 'L':
        case 'B':
        case 'V':
        case 'T':
        case 'R':
        case 'O':
            return Slot::type;
        case 'D':
        case 'G':
        case 'S':
        case 's':
            return Slot::scatter;
        default:
            return Slot::unknown;
    }
}

LabelTest one_symbol(std::string name) {
    return {false, {std::move(name)}, {}};
}

class OslParser {
  public:
    OslParser(const SourceText& source, BarReading bar) : source_(source), text_(source.text()), bar_(bar) {}

    Expression run() {
        expression_.dialect = Dialect::osl;
        if (text_.empty()) {
            source_.fail_at(0, "the expression is empty; expected an event such as C", "the beauty is C.*");
        }
        if (at('(')) {
            expression_.root = parse_parenthesis();
            if (position_ < text_.size()) {
                expression_.warnings.push_back(
                    "everything after the ')' that closes the leading '(' is ignored, as in OSL: '" +
                    std::string(text_.substr(position_, 40)) + "'");
            }
        } else {
            expression_.root = parse_items('\0');
        }
        return std::move(expression_);
    }

  private:
    [[nodiscard]] bool at(char c) const { return position_ < text_.size() && text_[position_] == c; }
    [[nodiscard]] bool at_end() const { return position_ >= text_.size(); }

    void enter(std::size_t offset) {
        if (++depth_ > limits::nesting) {
            source_.fail_at(offset, "brackets are nested deeper than " + std::to_string(limits::nesting));
        }
    }

    // ---- whole events -------------------------------------------------------------------------------------------

    /// Parses items up to `closer` (not consumed) or the end of the text. '|' joins the previous and the next item.
    NodePtr parse_items(char closer) {
        NodePtr sequence = make_node(NodeKind::sequence);
        NodePtr choices;  // loose reading only
        bool can_join = false;
        bool join_next = false;
        bool chained = false;  // the last item is a chain of '|'
        while (!at_end() && !(closer != '\0' && at(closer))) {
            if (at('|')) {
                if (!can_join) {
                    source_.fail_at(position_, "'|' has nothing on its left; expected an event before it");
                }
                ++position_;
                if (at_end() || (closer != '\0' && at(closer))) {
                    source_.fail_at(position_, "'|' has nothing on its right; expected an event after it");
                }
                expression_.has_bar = true;
                can_join = false;
                join_next = true;
                if (bar_ == BarReading::loose) {
                    choices = choices ? std::move(choices) : make_node(NodeKind::alternatives);
                    choices->children.push_back(
                        placed_around_children(std::exchange(sequence, make_node(NodeKind::sequence))));
                    join_next = chained = false;
                }
                continue;
            }
            NodePtr item = parse_item();
            if (join_next) {
                // A whole chain becomes one node, because later stages walk the tree recursively.
                NodePtr joined = chained ? std::move(sequence->children.back()) : make_node(NodeKind::alternatives);
                if (!chained) joined->children.push_back(std::move(sequence->children.back()));
                joined->children.push_back(std::move(item));
                item = placed_around_children(std::move(joined));
                sequence->children.pop_back();
            }
            chained = std::exchange(join_next, false);
            sequence->children.push_back(std::move(item));
            can_join = true;
        }
        sequence = placed_around_children(std::move(sequence));
        if (choices) {
            choices->children.push_back(std::move(sequence));
            return placed_around_children(std::move(choices));
        }
        return sequence;
    }

    NodePtr parse_item() {
        NodePtr atom;
        const std::size_t opening = position_;
        if (at('(')) {
            atom = parse_parenthesis();
        } else if (at('[')) {
            atom = parse_list();
        } else if (at('<')) {
            atom = make_event(parse_group());
        } else {
            atom = make_event(parse_letter());
        }
        return parse_modifier(placed(std::move(atom), opening, position_));
    }

    NodePtr parse_parenthesis() {
        const std::size_t opening = position_++;
        enter(opening);
        NodePtr inner = parse_items(')');
        if (at_end()) {
            source_.fail_at(position_, "found the end of the expression; expected ')' for the '(' at column " +
                                           std::to_string(opening + 1));
        }
        if (inner->kind == NodeKind::sequence && inner->children.empty()) {
            source_.fail_at(position_, "'()' is empty; expected an event inside");
        }
        ++position_;
        --depth_;
        return inner;
    }

    NodePtr parse_list() {
        const std::size_t opening = position_++;
        if (at('^')) { return make_event(parse_negated_list(opening)); }
        enter(opening);
        NodePtr list = make_node(NodeKind::alternatives);
        while (!at_end() && !at(']')) { list->children.push_back(parse_item()); }
        expect_closing(']', '[', opening);
        --depth_;
        return list;
    }

    EventSet parse_negated_list(std::size_t opening) {
        const auto [test, slot] = parse_negated_symbols(opening);
        SymbolSequence symbols(2, LabelTest::any());
        if (slot == Slot::label) {
            symbols.push_back(test);
        } else {
            symbols[static_cast<std::size_t>(slot)] = test;
        }
        return osl_events({symbols}, true, source_.vocabulary());
    }

    NodePtr parse_modifier(NodePtr atom) {
        int min = 0;
        int max = Node::unbounded;
        if (at('*')) {
            ++position_;
        } else if (at('+')) {
            ++position_;
            min = 1;
        } else if (at('{')) {
            std::tie(min, max) = parse_range();
        } else {
            return atom;
        }
        NodePtr repeat = make_node(NodeKind::repeat);
        repeat->min = min;
        repeat->max = max;
        const std::size_t begin = atom->begin;
        repeat->children.push_back(std::move(atom));
        return placed(std::move(repeat), begin, position_);
    }

    std::pair<int, int> parse_range() {
        const std::size_t opening = position_++;
        const int min = parse_count();
        int max = min;
        if (min >= 0 && at(',')) {
            ++position_;
            max = parse_count();
            max = max < 0 ? Node::unbounded : std::max(min, max);
        }
        if (min < 0 || !at('}')) {
            source_.fail_at(position_, "found " + source_.describe(position_) +
                                           " in the repetition that starts at column " + std::to_string(opening + 1) +
                                           "; expected {n}, {n,} or {n,m}");
        }
        ++position_;
        return {min, max};
    }

    /// Parses a decimal number; -1 when there is none.
    int parse_count() {
        const std::size_t begin = position_;
        int count = -1;
        while (!at_end() && text_[position_] >= '0' && text_[position_] <= '9') {
            count = std::max(count, 0) * 10 + (text_[position_] - '0');
            if (count > limits::repetitions) {
                source_.fail_at(begin, "a repetition count is above " + std::to_string(limits::repetitions));
            }
            ++position_;
        }
        return count;
    }

    /// Parses a letter or quoted label that matches a whole event.
    EventSet parse_letter() {
        const std::size_t offset = position_;
        const auto [name, quoted] = parse_symbol();
        SymbolSequence symbols(2, LabelTest::any());
        if (quoted && source_.vocabulary() != nullptr && source_.vocabulary()->cores(name)) {
            symbols[source_.vocabulary()->is_event(name) ? 0 : 1] = one_symbol(name);
        } else if (quoted) {
            symbols.push_back(one_symbol(name));
        } else if (name != ".") {
            const Slot slot = slot_of(name.front());
            if (slot == Slot::unknown) { fail_unknown(offset); }
            symbols[static_cast<std::size_t>(slot)] = one_symbol(name);
        }
        return osl_events({symbols}, true, source_.vocabulary());
    }

    [[noreturn]] void fail_unknown(std::size_t offset) const {
        std::string hint = source_.look_alike_hint(offset);
        const char c = text_[offset];
        if (hint.empty() && (c == ' ' || c == '\t' || c == '\n')) {
            hint = "the osl dialect has no blanks between events; --dialect renderman allows them";
        } else if (hint.empty() && ((c >= '0' && c <= '9') || c == 'U' || c == ';' || c == ':' || c == '?')) {
            hint = "lobe numbers, user events, prefixes and '?' belong to the renderman dialect";
        }
        source_.fail_at(offset,
                        "found " + source_.describe(offset) +
                            "; expected an event: C L B V T R O D G S s . 'label' <...> [...] or (...)",
                        hint);
    }

    // ---- symbols inside <...> -----------------------------------------------------------------------------------

    /// Parses one byte or a quoted text; the second value is true for a quoted text. A quoted text is compared
    /// verbatim: 'x' is an ordinary label, and 'D' is the symbol D.
    std::pair<std::string, bool> parse_symbol() {
        if (at('x')) {
            ++position_;
            return {std::string(none_symbol), false};
        }
        if (!at('\'')) { return {std::string(1, text_[position_++]), false}; }
        const std::size_t opening = position_;
        const std::size_t end = text_.find('\'', opening + 1);
        if (end == std::string_view::npos) { source_.fail_at(opening, "the quote is not closed; expected a second '"); }
        position_ = end + 1;
        return {std::string(text_.substr(opening + 1, end - opening - 1)), true};
    }

    /// Parses [^...] from its '[': the excluded symbols, and the slot of the last one.
    std::pair<LabelTest, Slot> parse_negated_symbols(std::size_t opening) {
        ++position_;  // '^'
        LabelTest test = LabelTest::any();
        Slot slot = Slot::unknown;
        while (!at_end() && !at(']')) {
            const std::size_t offset = position_;
            const auto [name, quoted] = parse_symbol();
            slot = quoted ? Slot::label : slot_of(name.front());
            if (slot == Slot::unknown) {
                source_.fail_at(offset,
                                "found " + source_.describe(offset) +
                                    " inside [^...]; expected letters of C L B V T R O D G S s or quoted labels",
                                source_.look_alike_hint(offset));
            }
            test.add_name(name);
        }
        if (!at_end() && slot == Slot::unknown) {
            source_.fail_at(position_, "'[^]' is empty; expected letters or quoted labels to exclude");
        }
        expect_closing(']', '[', opening);
        return {std::move(test), slot};
    }

    void expect_closing(char closer, char opener, std::size_t opening) {
        if (!at(closer)) {
            source_.fail_at(position_, "found " + source_.describe(position_) + "; expected '" +
                                           std::string(1, closer) + "' for the '" + std::string(1, opener) +
                                           "' at column " + std::to_string(opening + 1));
        }
        ++position_;
    }

    EventSet parse_group() {
        const std::size_t opening = position_++;
        SymbolSequences sequences{{}};
        std::size_t items = 0;
        while (!at_end() && !at('>')) {
            const std::size_t offset = position_;
            sequences = concatenate(sequences, parse_symbol_item(), offset);
            ++items;
        }
        expect_closing('>', '<', opening);
        for (SymbolSequence& sequence : sequences) {
            for (std::size_t missing = std::min<std::size_t>(items, 2); missing < 2; ++missing) {
                sequence.push_back(LabelTest::any());
            }
        }
        return osl_events(sequences, items < 2 + 5, source_.vocabulary());
    }

    SymbolSequences parse_symbol_item() {
        const std::size_t offset = position_;
        SymbolSequences item;
        if (at('<')) { source_.fail_at(offset, "found '<' inside <...>; groups do not nest"); }
        if (at('(')) {
            item = parse_symbol_parenthesis();
        } else if (at('[')) {
            item = parse_symbol_list();
        } else {
            const auto [name, quoted] = parse_symbol();
            // OSL compares only the text, so a quoted '.' is the wildcard, too.
            item = {{name == "." ? LabelTest::any() : one_symbol(name)}};
        }
        if (at('*') || at('+') || at('{')) {
            source_.fail_at(position_,
                            "found " + source_.describe(position_) + "; repetitions are not allowed inside <...>");
        }
        return item;
    }

    SymbolSequences parse_symbol_parenthesis() {
        const std::size_t opening = position_++;
        enter(opening);
        SymbolSequences whole{{}};
        SymbolSequences last;
        bool has_last = false;
        bool joining = false;
        while (!at_end() && !at(')')) {
            const std::size_t offset = position_;
            if (at('|')) {
                if (!has_last || joining) {
                    source_.fail_at(offset, "'|' has nothing on its left; expected a symbol before it");
                }
                ++position_;
                joining = true;
                continue;
            }
            SymbolSequences item = parse_symbol_item();
            if (joining) {
                add_alternatives(last, std::move(item));
                joining = false;
            } else {
                whole = has_last ? concatenate(whole, last, offset) : std::move(whole);
                last = std::move(item);
                has_last = true;
            }
        }
        if (joining || !has_last) {
            source_.fail_at(position_, "found " + source_.describe(position_) + "; expected a symbol");
        }
        expect_closing(')', '(', opening);
        --depth_;
        return concatenate(whole, last, opening);
    }

    SymbolSequences parse_symbol_list() {
        const std::size_t opening = position_++;
        if (at('^')) { return {{parse_negated_symbols(opening).first}}; }
        enter(opening);
        SymbolSequences list;
        while (!at_end() && !at(']')) { add_alternatives(list, parse_symbol_item()); }
        expect_closing(']', '[', opening);
        --depth_;
        return list;
    }

    SymbolSequences concatenate(const SymbolSequences& left, const SymbolSequences& right, std::size_t offset) const {
        SymbolSequences result;
        if (left.size() * right.size() > limits::group_variants) {
            source_.fail_at(offset, "this <...> contains more than " + std::to_string(limits::group_variants) +
                                        " symbol sequences");
        }
        for (const SymbolSequence& head : left) {
            for (const SymbolSequence& tail : right) {
                result.push_back(head);
                result.back().insert(result.back().end(), tail.begin(), tail.end());
            }
        }
        return result;
    }

    const SourceText& source_;
    std::string_view text_;
    BarReading bar_;
    std::size_t position_ = 0;
    int depth_ = 0;
    Expression expression_;
};

}  // namespace

Expression parse_osl(const SourceText& text, BarReading bar) {
    return OslParser(text, bar).run();
}

}  // namespace raylex::lpe
