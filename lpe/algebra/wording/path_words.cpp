#include "lpe/algebra/wording/path_words.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

namespace raylex::lpe {

namespace {

constexpr int most_nodes = 400;  ///< limit on described nodes; "..." replaces the rest of a longer expression
constexpr int most_depth = 12;
constexpr std::size_t most_pieces = 60;
constexpr const char* ellipsis = "...";

/// Collects the events of a node that is one event, or a choice among single events; otherwise returns false.
bool single_events(const Node& node, std::vector<const Node*>& events) {
    if (node.kind == NodeKind::event) {
        events.push_back(&node);
        return true;
    }
    const bool one_child = node.kind == NodeKind::sequence && node.children.size() == 1;
    if (node.children.empty() || (node.kind != NodeKind::alternatives && !one_child)) { return false; }
    return std::all_of(node.children.begin(), node.children.end(),
                       [&](const NodePtr& child) { return single_events(*child, events); });
}

std::string number_word(int number) {
    constexpr std::array<std::string_view, 13> words{"no",    "one",   "two",  "three", "four",   "five",  "six",
                                                     "seven", "eight", "nine", "ten",   "eleven", "twelve"};
    return number < static_cast<int>(words.size()) ? std::string(words[static_cast<std::size_t>(number)])
                                                   : std::to_string(number);
}

/// "one diffuse reflection", "any number of scatterings of any kind", "up to three ..."
std::string counted_words(const EventPhrase& phrase, int min, int max) {
    if (min == 1 && max == 1) { return "one " + joined_by(phrase.one); }
    if (min == 0 && max == 1) { return "at most one " + joined_by(phrase.one); }
    const std::string many = joined_by(phrase.many);
    if (max == Node::unbounded) { return (min == 0 ? "any number of " : number_word(min) + " or more ") + many; }
    if (min == max) { return number_word(min) + " " + many; }
    return (min == 0 ? "up to " + number_word(max) : number_word(min) + " to " + number_word(max)) + " " + many;
}

/// The words after "ending at".
std::string end_words(const EventPhrase& phrase) {
    return joined_by(phrase.one, phrase.one.size() == 2 ? " or at " : " or ");
}

/// A part of a sentence, in parentheses if it contains commas or semicolons.
std::string set_apart(const std::string& text) {
    return text.find_first_of(",;") == std::string::npos ? text : "(" + text + ")";
}

std::string times_words(int min, int max) {
    if (max == Node::unbounded) {
        return min == 0 ? "any number of times" : min == 1 ? "once or more" : number_word(min) + " times or more";
    }
    if (min == max) { return number_word(min) + " times"; }
    return min == 0 ? "up to " + number_word(max) + " times" : number_word(min) + " to " + number_word(max) + " times";
}

}  // namespace

PathTeller::PathTeller(const EventTeller& events, const EventTeller::Members& occurring, const Node& root)
    : events_(events), occurring_(occurring), root_(root), roles_(root) {}

bool PathTeller::too_long(const Node& /*node*/) {
    return ++said_ > most_nodes || depth_ > most_depth;
}

/// Describes the events of these nodes that can have the role.
EventPhrase PathTeller::phrase(const std::vector<const Node*>& nodes, EventRole role) {
    std::vector<const Node*> able;
    for (const Node* node : nodes) {
        if (roles_.can_be(*node, role)) { able.push_back(node); }
    }
    if (able.empty()) { return {}; }
    const auto known = phrases_.find({able, role});
    if (known != phrases_.end()) { return known->second; }
    const EventTeller::Members members = [&](const Event& event) {
        if (role_of(event.type) != role || occurring_(event) != Membership::in) { return Membership::never; }
        const bool in =
            std::any_of(able.begin(), able.end(), [&](const Node* node) { return matches(node->events, event); });
        return in ? Membership::in : Membership::out;
    };
    return phrases_.emplace(std::pair{able, role}, events_.phrase(events_.boxes(members), role)).first->second;
}

std::vector<PathTeller::Step> PathTeller::event_steps(const Node& node, const std::vector<const Node*>& events,
                                                      Count count) {
    std::vector<Step> result;
    if (count.max == 0) { return result; }
    const bool camera = !phrase(events, EventRole::camera).empty();
    EventPhrase middle = phrase(events, EventRole::scattering);
    EventPhrase user = phrase(events, EventRole::user);
    std::move(user.one.begin(), user.one.end(), std::back_inserter(middle.one));
    std::move(user.many.begin(), user.many.end(), std::back_inserter(middle.many));
    const EventPhrase end = phrase(events, EventRole::terminal);
    if (!camera && middle.empty() && end.empty()) { return {{StepKind::middle, "an event that cannot occur here"}}; }
    const auto one_less = [&count] {
        count.min = std::max(count.min - 1, 0);
        count.max = count.max == Node::unbounded ? Node::unbounded : count.max - 1;
    };
    if (camera) {
        result.push_back({StepKind::camera, "from the camera"});
        one_less();
    }
    const bool ends = !end.empty() && roles_.always_ends(node);
    if (ends) { one_less(); }
    if (!middle.empty() && count.max != 0) {
        result.push_back({StepKind::middle, counted_words(middle, count.min, count.max)});
    }
    if (ends) {
        result.push_back({StepKind::end, end_words(end), joined_by(end.one)});
    } else if (!end.empty()) {
        const std::string text = !roles_.possible() ? "the end at "
                                 : middle.empty()   ? "possibly the end at "
                                                    : "or already the end at ";
        result.push_back({StepKind::middle, text + end_words(end)});
    }
    return result;
}

std::vector<PathTeller::Step> PathTeller::repeat_steps(const Node& node) {
    const Node& child = *node.children.front();
    std::vector<const Node*> events;
    if (single_events(child, events)) { return event_steps(node, events, {node.min, node.max}); }
    if (node.max == 0) { return {}; }
    const bool camera = std::exchange(after_camera_, false);
    const std::string inner = join(steps(child), true);
    after_camera_ = camera;
    if (node.min == 0 && node.max == 1) { return {{StepKind::middle, "optionally (" + inner + ")"}}; }
    return {{StepKind::middle, times_words(node.min, node.max) + " (" + inner + ")"}};
}

std::vector<PathTeller::Step> PathTeller::choice_steps(const Node& node) {
    // Flattens nested choices.
    std::vector<const Node*> options;
    for (const NodePtr& child : node.children) {
        const bool nested = child->kind == NodeKind::alternatives;
        std::vector<const Node*> events;
        if (nested && !single_events(*child, events)) {
            for (const NodePtr& grandchild : child->children) { options.push_back(grandchild.get()); }
        } else {
            options.push_back(child.get());
        }
    }
    std::vector<std::string> texts;
    bool lettered = false;
    bool camera = false;
    for (const Node* option : options) {
        const bool after_camera = after_camera_;
        const std::vector<Step> parts = steps(*option);
        camera = camera || (!parts.empty() && parts.front().kind == StepKind::camera);
        texts.push_back(join(parts, true));
        after_camera_ = after_camera;
        lettered = lettered || texts.back().find(',') != std::string::npos;
    }
    std::string text = "either ";
    for (std::size_t i = 0; i < texts.size(); ++i) {
        text += i == 0 ? "" : lettered ? "; or " : " or ";
        text += lettered ? "(" + (i < 26 ? std::string(1, static_cast<char>('a' + i)) : std::to_string(i + 1)) + ") " +
                               texts[i]
                         : texts[i];
    }
    return {{camera ? StepKind::camera : StepKind::middle, text}};
}

/// Describes the operators '&', '-' and '!'.
std::vector<PathTeller::Step> PathTeller::language_steps(const Node& node) {
    const bool camera = after_camera_;
    std::string text;
    const std::string first = join(steps(*node.children.front()), true);
    after_camera_ = camera;
    if (node.kind == NodeKind::complement) {
        text = "any path that does not go " + set_apart(first);
    } else {
        const std::string second = join(steps(*node.children.back()), true);
        text = node.kind == NodeKind::difference ? first + "; but not " + set_apart(second)
                                                 : "what is both (" + first + ") and (" + second + ")";
    }
    after_camera_ = false;
    return {{StepKind::camera, text}};
}

std::vector<PathTeller::Step> PathTeller::steps(const Node& node) {
    if (too_long(node)) { return {{StepKind::middle, ellipsis}}; }
    ++depth_;
    std::vector<Step> result;
    std::vector<const Node*> events;
    if (single_events(node, events)) {
        result = event_steps(node, events, {1, 1});
    } else if (node.kind == NodeKind::sequence) {
        for (const NodePtr& child : node.children) {
            std::vector<Step> part = steps(*child);
            after_camera_ = part.empty()
                                ? after_camera_
                                : part.back().kind == StepKind::camera && part.back().text == "from the camera";
            std::move(part.begin(), part.end(), std::back_inserter(result));
        }
    } else if (node.kind == NodeKind::repeat) {
        result = repeat_steps(node);
    } else if (node.kind == NodeKind::alternatives) {
        result = choice_steps(node);
    } else {
        result = language_steps(node);
    }
    --depth_;
    return result;
}

/// Joins steps to a sentence. `inner`: the steps are part of a larger phrase, so their path can begin after the camera.
std::string PathTeller::join(const std::vector<Step>& steps, bool inner) const {
    std::string text;
    bool straight = inner && after_camera_;  // nothing has happened since the camera
    for (const Step& step : steps) {
        switch (step.kind) {
            case StepKind::camera:
                text += (text.empty() ? "" : ", then ") + step.text;
                straight = true;
                break;
            case StepKind::middle:
                text += (text.empty() ? "" : straight ? ", " : ", then ") + step.text;
                straight = false;
                break;
            case StepKind::end:
                text += straight       ? (text.empty() ? "straight to " : " straight to ")
                        : text.empty() ? "the end at "
                                       : ", ending at ";
                text += straight ? step.straight : step.text;
                break;
        }
    }
    return text.empty() ? "nothing" : text;
}

std::string PathTeller::sentence() {
    said_ = 0;
    after_camera_ = false;
    return join(steps(root_), false);
}

void PathTeller::add_pieces(const Node& node, int depth, std::vector<Piece>& pieces) {
    if (pieces.size() > most_pieces || depth > most_depth) { return; }
    std::vector<const Node*> events;
    const bool simple = single_events(node, events);
    if (!simple && node.kind == NodeKind::sequence) {
        for (const NodePtr& child : node.children) { add_pieces(*child, depth, pieces); }
        return;
    }
    if (pieces.size() == most_pieces) {
        pieces.push_back({node.begin, node.end, depth, "... and so on"});
        return;
    }
    const bool repeated_group =
        !simple && node.kind == NodeKind::repeat && !single_events(*node.children.front(), events);
    if (simple || (node.kind == NodeKind::repeat && !repeated_group)) {
        said_ = 0;
        const std::vector<Step> parts = steps(node);
        std::string words = join(parts, false);
        if (parts.size() == 1 && parts.front().kind == StepKind::camera) { words = "the camera"; }
        pieces.push_back({node.begin, node.end, depth, words});
        return;
    }
    std::string head;
    switch (node.kind) {
        case NodeKind::repeat:
            head = node.min == 0 && node.max == 1 ? "this or nothing:" : times_words(node.min, node.max) + ", this:";
            break;
        case NodeKind::complement:
            head = "every path but those that this accepts:";
            break;
        case NodeKind::intersection:
            head = "paths that both of these accept:";
            break;
        case NodeKind::difference:
            head = "paths that the first of these accepts and the second does not:";
            break;
        default:
            head = "one of these:";
    }
    pieces.push_back({node.begin, node.end, depth, head});
    for (const NodePtr& child : node.children) {
        const bool long_option =
            node.kind != NodeKind::repeat && child->kind == NodeKind::sequence && child->children.size() > 1;
        if (long_option) {
            said_ = 0;
            after_camera_ = false;
            pieces.push_back({child->begin, child->end, depth + 1, join(steps(*child), true)});
        } else {
            add_pieces(*child, depth + 1, pieces);
        }
    }
}

std::vector<Piece> PathTeller::pieces() {
    std::vector<Piece> pieces;
    add_pieces(root_, 0, pieces);
    return pieces;
}

}  // namespace raylex::lpe
