#include "lpe/algebra/wording/regex.h"

#include <algorithm>
#include <utility>

namespace raylex::lpe {

namespace {

using Kind = Regex::Kind;

bool same(const RegexPtr& a, const RegexPtr& b) {
    return a->text == b->text;
}

/// A part and its repetition counts; a part that is not repeated counts once.
struct Counted {
    RegexPtr part;
    int min = 1, max = 1;
};

Counted counted(const RegexPtr& regex) {
    if (regex->kind == Kind::repeat) { return {regex->parts.front(), regex->min, regex->max}; }
    return {regex, 1, 1};
}

int plus(int a, int b) {
    return a == Regex::unbounded || b == Regex::unbounded ? Regex::unbounded : a + b;
}

std::vector<RegexPtr> parts_of(const RegexPtr& regex) {
    if (regex->kind == Kind::epsilon) { return {}; }
    return regex->kind == Kind::sequence ? regex->parts : std::vector<RegexPtr>{regex};
}

/// The text as one atom, to which a repetition can be attached.
std::string atom(const RegexPtr& regex) {
    return regex->kind == Kind::events ? regex->text : "(" + regex->text + ")";
}

std::string suffix(int min, int max) {
    if (max == Regex::unbounded) { return min == 0 ? "*" : min == 1 ? "+" : "{" + std::to_string(min) + ",}"; }
    if (min == 0 && max == 1) { return "?"; }
    return min == max ? "{" + std::to_string(min) + "}" : "{" + std::to_string(min) + "," + std::to_string(max) + "}";
}

/// The text as one of several alternatives: in parentheses unless it is a single item.
std::string choice(const RegexPtr& regex) {
    return regex->kind == Kind::sequence ? "(" + regex->text + ")" : regex->text;
}

}  // namespace

RegexPtr RegexBuilder::finish(Regex regex) {
    switch (regex.kind) {
        case Kind::epsilon:
            regex.text.clear();
            break;
        case Kind::events:
            break;  // events() writes the text
        case Kind::sequence:
            for (const RegexPtr& part : regex.parts) { regex.text += part->text; }
            break;
        case Kind::alternatives:
            // The parentheses make both readings of '|' agree.
            for (const RegexPtr& part : regex.parts) { regex.text += (regex.text.empty() ? "(" : "|") + choice(part); }
            regex.text += ")";
            break;
        case Kind::repeat: {
            const RegexPtr& part = regex.parts.front();
            // Alternatives already have parentheses.
            regex.text = (part->kind == Kind::alternatives ? part->text : atom(part)) + suffix(regex.min, regex.max);
            break;
        }
    }
    failed_ = failed_ || regex.text.size() > longest_;
    return std::make_shared<const Regex>(std::move(regex));
}

RegexPtr RegexBuilder::epsilon() {
    Regex regex;
    regex.nullable = true;
    return finish(std::move(regex));
}

RegexPtr RegexBuilder::events(ClassSet set) {
    Regex regex;
    regex.kind = Kind::events;
    std::optional<std::string> text = write_(set);
    failed_ = failed_ || !text;
    regex.text = text ? *text : "";
    regex.events = std::move(set);
    return finish(std::move(regex));
}

RegexPtr RegexBuilder::repeat(const RegexPtr& part, int min, int max) {
    if (part->kind == Kind::epsilon || (min == 1 && max == 1)) { return part; }
    const Counted inner = counted(part);
    // (X?)* = (X+)* = (X*)+ = X*, (X+)? = X*: nested repetitions without gaps.
    if (part->kind == Kind::repeat && inner.min <= 1 && (inner.max == Regex::unbounded || max == Regex::unbounded) &&
        min <= 1) {
        return repeat(inner.part, std::min(inner.min, min), Regex::unbounded);
    }
    if (part->nullable && max == Regex::unbounded) { min = 0; }
    if (part->nullable && min == 0 && max == 1) { return part; }
    Regex regex;
    regex.kind = Kind::repeat;
    regex.parts = {part};
    regex.min = min;
    regex.max = max;
    regex.nullable = min == 0 || part->nullable;
    return finish(std::move(regex));
}

RegexPtr RegexBuilder::star(const RegexPtr& a) {
    if (!a) { return epsilon(); }
    if (a->kind == Kind::repeat && a->min == 0 && a->max == 1) { return repeat(a->parts.front(), 0, Regex::unbounded); }
    return repeat(a, 0, Regex::unbounded);
}

RegexPtr RegexBuilder::sequence_of(std::vector<RegexPtr> parts) {
    // Join neighbours that repeat the same part: XX* = X+.
    std::vector<RegexPtr> joined;
    for (RegexPtr& part : parts) {
        if (!joined.empty()) {
            const Counted before = counted(joined.back()), here = counted(part);
            if (same(before.part, here.part)) {
                joined.back() = repeat(before.part, before.min + here.min, plus(before.max, here.max));
                continue;
            }
        }
        joined.push_back(std::move(part));
    }
    if (joined.empty()) { return epsilon(); }
    if (joined.size() == 1) { return joined.front(); }
    Regex regex;
    regex.kind = Kind::sequence;
    regex.nullable = std::all_of(joined.begin(), joined.end(), [](const RegexPtr& part) { return part->nullable; });
    regex.parts = std::move(joined);
    return finish(std::move(regex));
}

RegexPtr RegexBuilder::sequence(const RegexPtr& a, const RegexPtr& b) {
    if (!a || !b) { return nullptr; }
    std::vector<RegexPtr> parts = parts_of(a);
    for (RegexPtr& part : parts_of(b)) { parts.push_back(std::move(part)); }
    const auto optional = std::find_if(parts.begin(), parts.end(), [](const RegexPtr& part) {
        return part->kind == Kind::repeat && part->min == 0 && part->max == 1;
    });
    if (optional_mark_ || failed_ || parts.size() == 1 || optional == parts.end()) {
        return sequence_of(std::move(parts));
    }
    const auto at = optional - parts.begin();
    std::vector<RegexPtr> with = parts, without = parts;
    with[static_cast<std::size_t>(at)] = (*optional)->parts.front();
    without.erase(without.begin() + at);
    const auto all_of = [this](const std::vector<RegexPtr>& list) {
        RegexPtr whole = epsilon();
        for (const RegexPtr& part : list) { whole = sequence(whole, part); }
        return whole;
    };
    return alternatives(all_of(without), all_of(with));
}

/// Factors out a common first or last part: AX | AY = A(X|Y). Null when there is none.
RegexPtr RegexBuilder::factored(const RegexPtr& a, const RegexPtr& b, bool from_front) {
    std::vector<RegexPtr> left = parts_of(a), right = parts_of(b);
    if (left.empty() || right.empty()) { return nullptr; }
    const auto end_of = [&](std::vector<RegexPtr>& list) -> RegexPtr& {
        return from_front ? list.front() : list.back();
    };
    const Counted x = counted(end_of(left)), y = counted(end_of(right));
    if (!same(x.part, y.part)) { return nullptr; }
    // X{2,}A | XB = X(X+A | B): factoring one X at a time finds every overlap.
    RegexPtr shared;
    if (same(end_of(left), end_of(right))) {
        shared = end_of(left);
        left.erase(from_front ? left.begin() : left.end() - 1);
        right.erase(from_front ? right.begin() : right.end() - 1);
    } else if (x.min >= 1 && y.min >= 1) {
        const int common = std::min(x.min, y.min);
        shared = repeat(x.part, common, common);
        for (auto* side : {&left, &right}) {
            const Counted had = counted(end_of(*side));
            const int max = had.max == Regex::unbounded ? had.max : had.max - common;
            if (max == 0) {
                side->erase(from_front ? side->begin() : side->end() - 1);
            } else {
                end_of(*side) = repeat(had.part, had.min - common, max);
            }
        }
    } else {
        return nullptr;
    }
    if (!optional_mark_ && left.empty() != right.empty()) {
        const std::vector<RegexPtr>& more = left.empty() ? right : left;
        if (!std::all_of(more.begin(), more.end(), [](const RegexPtr& part) { return part->nullable; })) {
            return nullptr;  // the remainder would be (X)?
        }
    }
    const RegexPtr rest = alternatives(sequence_of(std::move(left)), sequence_of(std::move(right)));
    return from_front ? sequence(shared, rest) : sequence(rest, shared);
}

/// The union as one simpler expression, or null.
RegexPtr RegexBuilder::merged(const RegexPtr& a, const RegexPtr& b) {
    if (same(a, b)) { return a; }
    if (a->kind == Kind::events && b->kind == Kind::events) {
        ClassSet both = a->events;
        for (std::size_t k = 0; k < both.size(); ++k) { both[k] = both[k] || b->events[k]; }
        return events(std::move(both));
    }
    if (a->kind == Kind::epsilon || b->kind == Kind::epsilon) {
        const RegexPtr& other = a->kind == Kind::epsilon ? b : a;
        if (other->nullable) { return other; }
        return repeat(other, 0, 1);
    }
    const Counted x = counted(a), y = counted(b);
    if (same(x.part, y.part)) {
        // Join adjacent ranges: X | XX+ = X+.
        const bool touch =
            (x.max == Regex::unbounded || y.min <= x.max + 1) && (y.max == Regex::unbounded || x.min <= y.max + 1);
        if (touch) {
            const int max =
                x.max == Regex::unbounded || y.max == Regex::unbounded ? Regex::unbounded : std::max(x.max, y.max);
            return repeat(x.part, std::min(x.min, y.min), max);
        }
    }
    if (a->kind == Kind::sequence || b->kind == Kind::sequence) {
        RegexPtr shared = factored(a, b, false);
        return shared ? shared : factored(a, b, true);
    }
    return nullptr;
}

/// Merges the first two parts that can be merged; returns whether there were such parts.
bool RegexBuilder::merge(std::vector<RegexPtr>& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
        for (std::size_t j = i + 1; j < parts.size(); ++j) {
            if (RegexPtr both = merged(parts[i], parts[j])) {
                parts[i] = std::move(both);
                parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(j));
                return true;
            }
        }
    }
    return false;
}

RegexPtr RegexBuilder::alternatives_of(std::vector<RegexPtr> parts) {
    while (!failed_ && parts.size() > 1 && merge(parts)) {}
    if (parts.size() == 1) { return parts.front(); }
    Regex regex;
    regex.kind = Kind::alternatives;
    regex.nullable = std::any_of(parts.begin(), parts.end(), [](const RegexPtr& part) { return part->nullable; });
    regex.parts = std::move(parts);
    return finish(std::move(regex));
}

RegexPtr RegexBuilder::alternatives(const RegexPtr& a, const RegexPtr& b) {
    if (!a || !b) { return a ? a : b; }
    std::vector<RegexPtr> parts;
    for (const RegexPtr& side : {a, b}) {
        if (side->kind == Kind::alternatives) {
            parts.insert(parts.end(), side->parts.begin(), side->parts.end());
        } else {
            parts.push_back(side);
        }
    }
    return alternatives_of(std::move(parts));
}

std::string RegexBuilder::text(const RegexPtr& regex) const {
    if (regex->kind != Kind::alternatives) { return regex->text; }
    return regex->text.substr(1, regex->text.size() - 2);
}

}  // namespace raylex::lpe
