#include "oracle.h"

#include <algorithm>
#include <set>

namespace oracle {

using raylex::lpe::EventType;
using raylex::lpe::Scatter;

namespace {

enum class Kind { event, sequence, choice, repeat, complement, both, without };

bool is_user(const Event& event) {
    return event.type == EventType::user;
}
bool is_straight(const Event& event) {
    return event.type == EventType::transmission && event.scatter == Scatter::straight;
}
std::string label(const Event& event, std::size_t slot) {
    return slot < event.labels.size() ? event.labels[slot] : "";
}

/// The number of labels of an event in OSL's words, without trailing empty ones.
std::size_t oracle_label_count(const Event& event) {
    std::size_t count = event.labels.size();
    while (count > 0 && event.labels[count - 1].empty()) { --count; }
    return count;
}

/// No label of the event alphabet is named like one of OSL's symbols, so OSL's wildcard matches trailing labels.
std::vector<Token> marks(Dialect dialect) {
    std::vector<Token> list;
    for (const char* text : {"(", ")", "[", "]", "|", "*", "+", "{2}", "{0,1}"}) { list.push_back({text, {}}); }
    if (dialect == Dialect::renderman) {
        for (const char* text : {"?", "!", "&", "-"}) { list.push_back({text, {}}); }
    }
    return list;
}

std::vector<Token> build_tokens(Dialect dialect) {
    const bool renderman = dialect == Dialect::renderman;
    std::vector<Token> list = marks(dialect);
    const auto add = [&](const char* text, std::function<bool(const Event&)> test) {
        list.push_back({text, [test](const Event& event) { return !is_user(event) && test(event); }});
    };
    add("C", [](const Event& e) { return e.type == EventType::camera; });
    add("D", [](const Event& e) { return e.scatter == Scatter::diffuse; });
    add(".", [](const Event&) { return true; });
    add("S",
        [=](const Event& e) { return e.scatter == Scatter::singular || (renderman && e.scatter == Scatter::glossy); });
    add("L",
        [=](const Event& e) { return e.type == EventType::light || (renderman && e.type == EventType::background); });
    add("<RD>", [](const Event& e) { return e.type == EventType::reflection && e.scatter == Scatter::diffuse; });
    add("<.D'a'>", [](const Event& e) { return e.scatter == Scatter::diffuse && label(e, 0) == "a"; });
    add("[^D]", [](const Event& e) { return e.scatter != Scatter::diffuse; });
    add("<.D[^'a']>", [=](const Event& e) {
        return e.scatter == Scatter::diffuse && label(e, 0) != "a" && (renderman || oracle_label_count(e) > 0);
    });
    if (renderman) {
        add("<RD'a*'>", [](const Event& e) {
            return e.type == EventType::reflection && e.scatter == Scatter::diffuse && label(e, 0).rfind("a", 0) == 0;
        });
        add("D2", [](const Event& e) { return e.scatter == Scatter::diffuse && e.lobe_number == 2; });
        list.push_back({"U2", [](const Event& e) { return is_user(e) && e.lobe_number == 2; }});
    } else {
        add("<Ts>", is_straight);
        add("<RD.'b'>", [](const Event& e) {
            return e.type == EventType::reflection && e.scatter == Scatter::diffuse && oracle_label_count(e) > 1 &&
                   label(e, 1) == "b";
        });
    }
    return list;
}

}  // namespace

struct Tree {
    Kind kind = Kind::sequence;
    const Token* token = nullptr;
    int min = 0, max = 0;  // max -1: unlimited
    std::vector<std::shared_ptr<Tree>> children;
};

namespace {

using TreePtr = std::shared_ptr<Tree>;

TreePtr make(Kind kind, std::vector<TreePtr> children) {
    for (const TreePtr& child : children) {
        if (!child) { return nullptr; }
    }
    auto tree = std::make_shared<Tree>();
    tree->kind = kind;
    tree->children = std::move(children);
    return tree;
}

class Reader {
  public:
    Reader(const std::vector<std::size_t>& sequence, Dialect dialect) : sequence_(sequence), dialect_(dialect) {}

    TreePtr run() {
        if (sequence_.empty()) { return nullptr; }
        if (dialect_ == Dialect::osl) {
            return at("(") ? parenthesis() : osl_items("");  // OSL stops at the ')' of a leading '('
        }
        TreePtr tree = difference();
        return position_ == sequence_.size() ? tree : nullptr;
    }

  private:
    const Token* here() const {
        return position_ < sequence_.size() ? &tokens(dialect_)[sequence_[position_]] : nullptr;
    }
    bool at(const std::string& text) const { return here() != nullptr && here()->text == text; }
    bool take(const std::string& text) { return at(text) && ++position_ > 0; }

    TreePtr difference() {
        TreePtr tree = intersection();
        while (tree && take("-")) { tree = make(Kind::without, {tree, intersection()}); }
        return tree;
    }
    TreePtr intersection() {
        TreePtr tree = complement();
        while (tree && take("&")) { tree = make(Kind::both, {tree, complement()}); }
        return tree;
    }
    TreePtr complement() { return take("!") ? make(Kind::complement, {complement()}) : renderman_items(); }

    TreePtr renderman_items() {
        std::vector<TreePtr> items;
        while (here() != nullptr && !at(")") && !at("-") && !at("&")) {
            items.push_back(item());
            while (items.back() && take("|")) { items.back() = make(Kind::choice, {items.back(), item()}); }
            if (!items.back()) { return nullptr; }
        }
        return items.empty() ? nullptr : make(Kind::sequence, std::move(items));
    }

    TreePtr osl_items(const std::string& closer) {
        std::vector<TreePtr> items;
        while (here() != nullptr && !at(closer)) {
            if (take("|")) {
                if (items.empty()) { return nullptr; }
                items.back() = make(Kind::choice, {items.back(), item()});
            } else {
                items.push_back(item());
            }
            if (!items.back()) { return nullptr; }
        }
        return make(Kind::sequence, std::move(items));
    }

    TreePtr parenthesis() {
        ++position_;
        TreePtr tree = dialect_ == Dialect::osl ? osl_items(")") : difference();
        // '()' is refused, because OSL crashes on it.
        if (!tree || (tree->kind == Kind::sequence && tree->children.empty()) || !take(")")) { return nullptr; }
        return tree;
    }

    TreePtr item() {
        TreePtr tree;
        if (at("(")) {
            tree = parenthesis();
        } else if (take("[")) {
            std::vector<TreePtr> items;
            while (here() != nullptr && !at("]")) {
                items.push_back(item());
                if (!items.back()) { return nullptr; }
            }
            if (!take("]") || (items.empty() && dialect_ == Dialect::renderman)) { return nullptr; }
            tree = make(Kind::choice, std::move(items));
        } else if (here() != nullptr && here()->matches) {
            tree = make(Kind::event, {});
            tree->token = here();
            ++position_;
        }
        if (!tree) { return nullptr; }
        int min = 0, max = -1;
        if (take("+")) {
            min = 1;
        } else if (take("?") || take("{0,1}")) {
            max = 1;
        } else if (take("{2}")) {
            min = max = 2;
        } else if (!take("*")) {
            return tree;
        }
        TreePtr repeat = make(Kind::repeat, {tree});
        repeat->min = min;
        repeat->max = max;
        return repeat;
    }

    const std::vector<std::size_t>& sequence_;
    Dialect dialect_;
    std::size_t position_ = 0;
};

using Ends = std::set<std::size_t>;

/// The possible ends of a match that begins at `begin`.
Ends ends(const Tree& tree, const Path& path, std::size_t begin);

Ends ends_from(const Tree& tree, const Path& path, const Ends& begins) {
    Ends all;
    for (const std::size_t begin : begins) { all.merge(ends(tree, path, begin)); }
    return all;
}

Ends repeat_ends(const Tree& tree, const Path& path, std::size_t begin) {
    const Tree& child = *tree.children.front();
    Ends now{begin};
    for (int i = 0; i < tree.min; ++i) { now = ends_from(child, path, now); }
    Ends all = now;
    for (int i = tree.min; tree.max < 0 ? true : i < tree.max; ++i) {
        now = ends_from(child, path, now);
        const std::size_t before = all.size();
        all.insert(now.begin(), now.end());
        if (tree.max < 0 && all.size() == before) { break; }
    }
    return all;
}

Ends ends(const Tree& tree, const Path& path, std::size_t begin) {
    Ends result;
    switch (tree.kind) {
        case Kind::event:
            if (begin < path.size() && tree.token->matches(path[begin])) { result.insert(begin + 1); }
            break;
        case Kind::sequence:
            result = {begin};
            for (const TreePtr& child : tree.children) { result = ends_from(*child, path, result); }
            break;
        case Kind::choice:
            for (const TreePtr& child : tree.children) { result.merge(ends(*child, path, begin)); }
            break;
        case Kind::repeat:
            result = repeat_ends(tree, path, begin);
            break;
        case Kind::complement: {
            const Ends child = ends(*tree.children[0], path, begin);
            for (std::size_t end = begin; end <= path.size(); ++end) {
                if (end > begin && is_user(path[end - 1])) {
                    break;  // '!' complements within words without user events
                }
                if (child.count(end) == 0) { result.insert(end); }
            }
            break;
        }
        case Kind::both:
        case Kind::without: {
            const Ends second = ends(*tree.children[1], path, begin);
            for (const std::size_t end : ends(*tree.children[0], path, begin)) {
                if ((second.count(end) != 0) == (tree.kind == Kind::both)) { result.insert(end); }
            }
            break;
        }
    }
    return result;
}

std::size_t token_index(const std::string& text, Dialect dialect) {
    const auto& list = tokens(dialect);
    return static_cast<std::size_t>(
        std::find_if(list.begin(), list.end(), [&](const Token& token) { return token.text == text; }) - list.begin());
}

}  // namespace

const std::vector<Token>& tokens(Dialect dialect) {
    static const std::vector<Token> renderman = build_tokens(Dialect::renderman);
    static const std::vector<Token> osl = build_tokens(Dialect::osl);
    return dialect == Dialect::renderman ? renderman : osl;
}

std::shared_ptr<Tree> parse(const std::vector<std::size_t>& sequence, Dialect dialect) {
    return Reader(sequence, dialect).run();
}

bool matches(const Tree& tree, const Path& path, Dialect dialect) {
    Path seen = path;
    if (dialect == Dialect::renderman) { std::erase_if(seen, is_straight); }
    return ends(tree, seen, 0).count(seen.size()) != 0;
}

std::string text_of(const std::vector<std::size_t>& sequence, Dialect dialect) {
    std::string text;
    for (const std::size_t token : sequence) { text += tokens(dialect)[token].text; }
    return text;
}

const std::vector<Event>& alphabet() {
    static const std::vector<Event> events{
        {EventType::camera, Scatter::none, 0, {}},
        {EventType::reflection, Scatter::diffuse, 0, {}},
        {EventType::reflection, Scatter::diffuse, 2, {"a", "b"}},
        {EventType::transmission, Scatter::diffuse, 0, {"ab"}},
        {EventType::reflection, Scatter::glossy, 0, {"", "b"}},
        {EventType::transmission, Scatter::singular, 0, {"z"}},
        {EventType::transmission, Scatter::straight, 0, {"a"}},
        {EventType::light, Scatter::none, 0, {"a"}},
        {EventType::background, Scatter::none, 0, {}},
        {EventType::user, Scatter::none, 2, {}},
        {EventType::volume, Scatter::none, 0, {}},
    };
    return events;
}

namespace {

/// One event for each behaviour that the small tokens distinguish; the random tests use the whole alphabet.
std::vector<Event> small_alphabet(Dialect dialect) {
    const std::vector<Event>& all = alphabet();
    return {all[0], all[2], all[4], dialect == Dialect::osl ? all[6] : all[9], all[8]};
}

}  // namespace

std::vector<Path> all_paths(Dialect dialect, std::size_t longest) {
    const std::vector<Event> small = small_alphabet(dialect);
    std::vector<Path> paths{{}};
    std::size_t first = 0;
    for (std::size_t length = 1; length <= longest; ++length) {
        const std::size_t last = paths.size();
        for (; first < last; ++first) {
            for (const Event& event : small) {
                paths.push_back(paths[first]);
                paths.back().push_back(event);
            }
        }
    }
    return paths;
}

ShortPathStrings::ShortPathStrings(Dialect dialect, std::size_t longest)
    : longest_(longest), events_(small_alphabet(dialect)), words_(all_paths(dialect, longest)) {
    for (std::size_t length = 0, first = 0, count = 1; length <= longest; ++length, count *= events_.size()) {
        first_.push_back(first);
        first += count;
    }
    first_.push_back(words_.size());
    for (std::size_t w = 0; w < words_.size(); ++w) {
        without_user_[w] = std::none_of(words_[w].begin(), words_[w].end(), is_user);
    }
}

ShortPathStrings::Set ShortPathStrings::concatenated(const Set& a, const Set& b) const {
    // If words of one length are numbered by value, the words u v for one u and all v of one length have consecutive
    // numbers.
    Set result;
    std::size_t length = 0;
    for (std::size_t u = 0; u < words_.size(); ++u) {
        length += u == first_[length + 1] ? 1 : 0;
        if (!a[u]) continue;
        std::size_t run = 1;
        for (std::size_t rest = 0; length + rest <= longest_; ++rest, run *= events_.size()) {
            const std::size_t to = first_[length + rest] + (u - first_[length]) * run;
            for (std::size_t v = 0; v < run; ++v) {
                if (b[first_[rest] + v]) result.set(to + v);
            }
        }
    }
    return result;
}

ShortPathStrings::Set ShortPathStrings::language(const Tree& tree) const {
    Set result;
    switch (tree.kind) {
        case Kind::event:
            for (std::size_t k = 0; k < events_.size(); ++k) { result[1 + k] = tree.token->matches(events_[k]); }
            break;
        case Kind::sequence:
            result.set(0);
            for (const TreePtr& child : tree.children) result = concatenated(result, language(*child));
            break;
        case Kind::choice:
            for (const TreePtr& child : tree.children) result |= language(*child);
            break;
        case Kind::repeat: {
            const Set child = language(*tree.children.front());
            Set power;
            power.set(0);
            for (int i = 0; i < tree.min; ++i) power = concatenated(power, child);
            result = power;
            Set before;
            for (int i = tree.min; (tree.max < 0 || i < tree.max) && before != result; ++i) {
                before = result;
                power = concatenated(power, child);
                result |= power;
            }
            break;
        }
        case Kind::complement:
            result = without_user_ & ~language(*tree.children[0]);
            break;
        case Kind::both:
            result = language(*tree.children[0]) & language(*tree.children[1]);
            break;
        case Kind::without:
            result = language(*tree.children[0]) & ~language(*tree.children[1]);
            break;
    }
    return result;
}

std::vector<std::size_t> random_expression(Random& random, Dialect dialect, std::size_t size) {
    const auto mark = [&](const char* text) { return token_index(text, dialect); };
    const std::size_t events_begin = token_index("C", dialect);
    const auto join = [](std::vector<std::size_t> a, const std::vector<std::size_t>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    if (size <= 1) { return {events_begin + random.below(tokens(dialect).size() - events_begin)}; }
    const std::size_t left = 1 + random.below(size - 1);
    const auto a = random_expression(random, dialect, left);
    const auto b = random_expression(random, dialect, size - left);
    const auto wrapped = [&](const std::vector<std::size_t>& inner) {
        return join(join({mark("(")}, inner), {mark(")")});
    };
    switch (random.below(dialect == Dialect::renderman ? 10 : 7)) {
        case 0:
            return join(wrapped(a), join({mark("|")}, wrapped(b)));
        case 1:
            return join(a, join({mark("|")}, b));
        case 2:
            return join(join({mark("[")}, wrapped(a)), join(wrapped(b), {mark("]")}));
        case 3:
            return join(join(wrapped(a), {mark("*")}), b);
        case 4:
            return join(join(wrapped(a), {mark("{0,1}")}), b);
        case 7:
            return wrapped(join(wrapped(a), join({mark("-")}, b)));
        case 8:
            return wrapped(join(a, join({mark("&")}, b)));
        case 9:
            return join(wrapped(join({mark("!")}, a)), b);
        default:
            return join(a, b);
    }
}

Path random_path(Random& random, std::size_t longest) {
    Path path;
    for (std::size_t length = random.below(longest + 1); length > 0; --length) {
        path.push_back(alphabet()[random.below(alphabet().size())]);
    }
    return path;
}

}  // namespace oracle
