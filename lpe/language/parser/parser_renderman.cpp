// The parser of the `renderman` dialect: the language of RenderMan 20-27 (public documentation and
// RenderManForBlender's channel definitions), extended by `?`, blanks, '#' comments, label globs, V, B, G, '&', '-' and
// '!'. Grammar: lpe/README.md.
//
// Words of this dialect have no pass-through events. L is every light (L and B), S every specular lobe (G and S).
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "lpe/language/parser/parser.h"
#include "lpe/language/parser/renderman_events.h"
#include "lpe/language/prefixes.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

bool is_word_byte(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

class RendermanParser : private RendermanEvents {
  public:
    RendermanParser(const SourceText& source, BarReading bar) : RendermanEvents(source), bar_(bar) {}

    Expression run() {
        expression_.dialect = Dialect::renderman;
        parse_prefixes();
        if (at_end()) {
            source_.fail_at(position_, "the expression is empty; expected an event such as C", "the beauty is C.*");
        }
        expression_.root = parse_difference();
        if (!at_end()) { fail_unexpected("expected an event or the end of the expression"); }
        return std::move(expression_);
    }

  private:
    void enter(std::size_t offset) {
        if (++depth_ > limits::nesting) {
            source_.fail_at(offset, "brackets are nested deeper than " + std::to_string(limits::nesting));
        }
    }

    // ---- prefixes -----------------------------------------------------------------------------------------------

    void parse_prefixes() {
        for (;;) {
            if (at_end()) { return; }
            std::size_t end = position_;
            while (end < text_.size() && is_word_byte(text_[end])) { ++end; }
            if (end == position_ || end >= text_.size() || (text_[end] != ';' && text_[end] != ':')) { return; }
            const std::string_view word = text_.substr(position_, end - position_);
            if (text_[end] == ':') {
                if (word != "lpe" || !expression_.prefixes.empty()) {
                    source_.fail_at(position_, "found '" + std::string(word) +
                                                   ":'; expected 'lpe:' at the very beginning, or an event");
                }
            } else if (std::find(prefix_names.begin(), prefix_names.end(), word) == prefix_names.end() &&
                       !technique_prefix(word)) {
                const std::string near = nearest(word, prefix_names.data(), prefix_names.size());
                source_.fail_at(position_,
                                "unknown prefix '" + std::string(word) +
                                    "'; expected unoccluded, noclamp, nothruput, shadows, holdouts, overwrite, "
                                    "noinfinitecheck, unweighted, or a technique such as s2t3 or beyond7",
                                near.empty() ? "" : "did you mean '" + near + "'?");
            } else {
                expression_.prefixes.emplace_back(word);
            }
            position_ = end + 1;
        }
    }

    // ---- languages ----------------------------------------------------------------------------------------------

    NodePtr parse_difference() {
        NodePtr left = parse_intersection();
        for (std::size_t offset = position_; take('-'); offset = position_) {
            count_operator(offset);
            left = binary(NodeKind::difference, std::move(left), parse_intersection());
        }
        return left;
    }

    NodePtr parse_intersection() {
        NodePtr left = parse_complement();
        for (std::size_t offset = position_; take('&'); offset = position_) {
            count_operator(offset);
            left = binary(NodeKind::intersection, std::move(left), parse_complement());
        }
        return left;
    }

    /// A chain of operators is as deep a tree as nested brackets, and every later stage walks it recursively.
    void count_operator(std::size_t offset) {
        if (++operators_ > limits::operators) {
            source_.fail_at(offset, "found more than " + std::to_string(limits::operators) +
                                        " operators '&' and '-'; expected fewer in one expression");
        }
    }

    static NodePtr binary(NodeKind kind, NodePtr left, NodePtr right) {
        NodePtr node = make_node(kind);
        node->children.push_back(std::move(left));
        node->children.push_back(std::move(right));
        return placed_around_children(std::move(node));
    }

    NodePtr parse_complement() {
        at_end();
        const std::size_t offset = position_;
        if (!take('!')) { return parse_sequence(); }
        enter(offset);
        NodePtr node = make_node(NodeKind::complement);
        node->children.push_back(parse_complement());
        --depth_;
        const std::size_t end = node->children.front()->end;
        return placed(std::move(node), offset, end);
    }

    bool at_sequence_end() { return at_end() || at(')') || at('-') || at('&'); }

    NodePtr parse_sequence() {
        NodePtr choices;  // loose reading only
        NodePtr sequence = make_node(NodeKind::sequence);
        do {
            NodePtr item = parse_item();
            for (bool chained = false; at('|'); chained = true) {
                ++position_;
                expression_.has_bar = true;
                if (bar_ == BarReading::loose) {
                    choices = choices ? std::move(choices) : make_node(NodeKind::alternatives);
                    sequence->children.push_back(std::move(item));
                    choices->children.push_back(
                        placed_around_children(std::exchange(sequence, make_node(NodeKind::sequence))));
                    item = parse_item();
                } else if (chained) {  // one node for the whole chain, because later stages walk the tree recursively
                    item->children.push_back(parse_item());
                    item = placed_around_children(std::move(item));
                } else {
                    item = binary(NodeKind::alternatives, std::move(item), parse_item());
                }
            }
            sequence->children.push_back(std::move(item));
        } while (!at_sequence_end());
        sequence = placed_around_children(std::move(sequence));
        if (choices) {
            choices->children.push_back(std::move(sequence));
            return placed_around_children(std::move(choices));
        }
        return sequence;
    }

    NodePtr parse_item() {
        NodePtr atom;
        at_end();
        const std::size_t opening = position_;
        if (take('(')) {
            enter(opening);
            if (at(')')) { fail_unexpected("'()' is empty; expected an event inside"); }
            atom = parse_difference();
            expect_closing(')', '(', opening);
            --depth_;
        } else if (take('[')) {
            atom = parse_list(opening);
        } else {
            atom = make_event(parse_event());
        }
        return parse_repetition(placed(std::move(atom), opening, position_));
    }

    NodePtr parse_list(std::size_t opening) {
        enter(opening);
        NodePtr list;
        if (take('^')) {
            EventSet excluded;
            do {
                EventSet one = parse_event();
                std::move(one.any_of.begin(), one.any_of.end(), std::back_inserter(excluded.none_of));
            } while (!at_end() && !at(']'));
            excluded.any_of.push_back({wildcard_cores(Dialect::renderman), {}, Missing::is_empty, Extra::ignored});
            list = make_event(std::move(excluded));
        } else {
            list = make_node(NodeKind::alternatives);
            do { list->children.push_back(parse_item()); } while (!at_end() && !at(']'));
        }
        expect_closing(']', '[', opening);
        --depth_;
        return list;
    }

    NodePtr parse_repetition(NodePtr atom) {
        int min = 0;
        int max = Node::unbounded;
        if (take('+')) {
            min = 1;
        } else if (take('?')) {
            max = 1;
        } else if (at('{')) {
            std::tie(min, max) = parse_range();
        } else if (!take('*')) {
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
        if (min >= 0 && take(',')) {
            max = parse_count();
            if (max >= 0 && max < min) {
                source_.fail_at(opening, "the repetition {" + std::to_string(min) + "," + std::to_string(max) +
                                             "} counts down; expected {n,m} with n <= m");
            }
        }
        if (min < 0 || !take('}')) { fail_unexpected("expected a repetition {n}, {n,} or {n,m}"); }
        return {min, max};
    }

    int parse_count() {
        int count = Node::unbounded;
        at_end();
        const std::size_t begin = position_;
        while (position_ < text_.size() && text_[position_] >= '0' && text_[position_] <= '9') {
            count = std::max(count, 0) * 10 + (text_[position_] - '0');
            if (count > limits::repetitions) {
                source_.fail_at(begin, "a repetition count is above " + std::to_string(limits::repetitions));
            }
            ++position_;
        }
        return count;
    }

    BarReading bar_;
    int depth_ = 0;
    int operators_ = 0;
    Expression expression_;
};

}  // namespace

Expression parse_renderman(const SourceText& text, BarReading bar) {
    return RendermanParser(text, bar).run();
}

}  // namespace raylex::lpe
