#include "lpe/language/parser/renderman_events.h"

#include <algorithm>
#include <utility>

#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

const CoreSet& universe() {
    return wildcard_cores(Dialect::renderman);
}

CoreSet cores_of_type(EventType type) {
    CoreSet cores;
    for (int scatter = 0; scatter < scatter_kinds; ++scatter) {
        for (std::uint8_t number = 0; number < lobe_numbers; ++number) {
            cores.set(core_index({type, static_cast<Scatter>(scatter), number, {}}));
        }
    }
    return cores & universe();
}

/// All cores with this scattering; lobe number 0 means all numbers.
CoreSet cores_of_scatter(Scatter scatter, int number) {
    CoreSet cores;
    for (int type = 0; type < scene_types; ++type) {
        for (int k = 0; k < lobe_numbers; ++k) {
            if (number == 0 || k == number) {
                cores.set(core_index({static_cast<EventType>(type), scatter, static_cast<std::uint8_t>(k), {}}));
            }
        }
    }
    return cores & universe();
}

EventSet plain(const CoreSet& cores) {
    return {{{cores, {}, Missing::is_empty, Extra::ignored}}, {}};
}

std::string unescaped(const std::string& label) {
    std::string plain_label;
    for (std::size_t i = 0; i < label.size(); ++i) {
        if (label[i] == '\\' && i + 1 < label.size()) { ++i; }
        plain_label += label[i];
    }
    return plain_label;
}

}  // namespace

bool RendermanEvents::at_end() {
    while (position_ < text_.size()) {
        const char c = text_[position_];
        if (c == '#') {
            position_ = std::min(text_.find('\n', position_), text_.size());
        } else if (c == ' ' || c == '\t' || c == '\n' || c == '\r') {
            ++position_;
        } else {
            return false;
        }
    }
    return true;
}

bool RendermanEvents::take(char c) {
    if (!at(c)) { return false; }
    ++position_;
    return true;
}

void RendermanEvents::fail_unexpected(const std::string& expected) {
    at_end();
    std::string hint = source_.look_alike_hint(position_);
    const char c = position_ < text_.size() ? text_[position_] : '\0';
    if (hint.empty() && c == 's') {
        hint = "straight-through events leave no event in this dialect; --dialect osl writes them <Ts>";
    } else if (hint.empty() && c >= '0' && c <= '9') {
        hint = "a lobe number follows its letter directly, as in D2 or S8; a repetition is written {n}";
    } else if (hint.empty() && (c == '*' || c == '+' || c == '?' || c == '{')) {
        hint = "one repetition per event; use (...) to repeat a repetition";
    } else if (hint.empty() && c >= 'a' && c <= 'z') {
        hint = "labels are quoted, as in <RD'floor'>; a name inside an expression is written $name";
    } else if (hint.empty() && (c == 'E' || c == 'A' || c == 'P')) {
        hint = "events are C L O B V R T, lobes D G S and U1 to U12";
    }
    source_.fail_at(position_, "found " + source_.describe(position_) + "; " + expected, hint);
}

void RendermanEvents::expect_closing(char closer, char opener, std::size_t opening) {
    if (!take(closer)) {
        fail_unexpected("expected '" + std::string(1, closer) + "' for the '" + std::string(1, opener) +
                        "' at column " + std::to_string(opening + 1));
    }
}

EventSet RendermanEvents::parse_event() {
    if (at('<')) { return parse_group(); }
    CoreSet cores;
    if (take_registered(cores)) { return plain(cores); }
    if (at('\'')) {
        EventPattern pattern{universe(), {parse_labels()}, Missing::is_empty, Extra::ignored};
        return {{std::move(pattern)}, {}};
    }
    if (!take_type(cores) && !take_scatter(cores)) {
        if (at('!')) {
            fail_unexpected("'!' negates a whole expression and precedes it; [^...] excludes single events");
        }
        fail_unexpected("expected an event: C L O B V R T D G S U . 'label' <...> [...] or (...)");
    }
    return plain(cores);
}

bool RendermanEvents::take_type(CoreSet& cores) {
    if (at_end()) { return false; }
    switch (text_[position_]) {
        case '.':
            cores = universe();
            break;
        case 'C':
            cores = cores_of_type(EventType::camera);
            break;
        case 'R':
            cores = cores_of_type(EventType::reflection);
            break;
        case 'T':
            cores = cores_of_type(EventType::transmission);
            break;
        case 'V':
            cores = cores_of_type(EventType::volume);
            break;
        case 'B':
            cores = cores_of_type(EventType::background);
            break;
        case 'O':
            cores = cores_of_type(EventType::emission);
            break;
        case 'L':
            cores = cores_of_type(EventType::light) | cores_of_type(EventType::background);
            break;
        default:
            return false;
    }
    ++position_;
    return true;
}

bool RendermanEvents::take_scatter(CoreSet& cores) {
    if (at_end()) { return false; }
    switch (text_[position_]) {
        case 'G':
            ++position_;
            cores = cores_of_scatter(Scatter::glossy, 0);
            return true;
        case 'D':
            cores = cores_of_scatter(Scatter::diffuse, parse_lobe_number("D", 4));
            return true;
        case 'S': {
            const int number = parse_lobe_number("S", 8);
            cores = cores_of_scatter(Scatter::glossy, number) | cores_of_scatter(Scatter::singular, number);
            return true;
        }
        case 'U': {
            const std::size_t offset = position_;
            const int number = parse_lobe_number("U", 12);
            if (number == 0) { source_.fail_at(offset, "'U' needs its number; expected U1 to U12"); }
            cores.reset();
            cores.set(core_index({EventType::user, Scatter::none, static_cast<std::uint8_t>(number), {}}));
            return true;
        }
        default:
            return false;
    }
}

/// Parses the number directly after the letter at the position; 0 when there is none.
int RendermanEvents::parse_lobe_number(const std::string& letter, int highest) {
    const std::size_t begin = ++position_;
    int number = 0;
    while (position_ < text_.size() && text_[position_] >= '0' && text_[position_] <= '9') {
        number = std::min(number * 10 + (text_[position_] - '0'), 1000);
        ++position_;
    }
    if (position_ > begin && (number < 1 || number > highest)) {
        source_.fail_at(begin, "no such lobe: " + letter + std::string(text_.substr(begin, position_ - begin)) +
                                   "; expected " + letter + "1 to " + letter + std::to_string(highest));
    }
    return number;
}

// Parses <type scatter label label ...>.
EventSet RendermanEvents::parse_group() {
    const std::size_t opening = position_++;
    EventPattern pattern{universe(), {}, Missing::is_empty, Extra::ignored};
    if (at('>')) { fail_unexpected("'<>' is empty; expected an event type: C L O B V R T or ."); }
    pattern.cores = parse_slot(Slot::type);
    if (!at('>')) {
        const CoreSet scatter = parse_slot(Slot::scatter);
        // User events are not scene events; <.U2'label'> gives one a label.
        const bool user = (scatter & ~universe()).any();
        pattern.cores = user && pattern.cores == universe() ? scatter : pattern.cores & scatter;
    }
    while (!at_end() && !at('>')) { pattern.labels.push_back(parse_labels()); }
    expect_closing('>', '<', opening);
    while (!pattern.labels.empty() && pattern.labels.back().is_any()) { pattern.labels.pop_back(); }
    return {{std::move(pattern)}, {}};
}

CoreSet RendermanEvents::parse_slot(Slot slot) {
    std::size_t after = 0;
    if (at('\'') && (slot == Slot::type || !find_registered(after))) {
        fail_unexpected(slot == Slot::type ? "the first slot is the event type: C L O B V R T or ."
                                           : "the second slot is the scattering; write '.' there, as in <L.'key'>");
    }
    const std::size_t opening = position_;
    if (!take('[')) { return parse_slot_letter(slot); }
    const bool negated = take('^');
    CoreSet cores;
    do { cores |= parse_slot_letter(slot); } while (!at_end() && !at(']'));
    expect_closing(']', '[', opening);
    return negated ? universe() & ~cores : cores;
}

CoreSet RendermanEvents::parse_slot_letter(Slot slot) {
    CoreSet cores;
    const bool taken = slot == Slot::type
                           ? take_type(cores)
                           : (at('.') && take_type(cores)) || take_registered(cores) || take_scatter(cores);
    if (!taken) {
        fail_unexpected(slot == Slot::type ? "expected an event type: C L O B V R T . or [...] of them"
                                           : "expected a scattering: D G S D1-D4 S1-S8 . or [...] of them");
    }
    return cores;
}

std::optional<CoreSet> RendermanEvents::find_registered(std::size_t& after) {
    const Vocabulary* vocabulary = source_.vocabulary();
    if (vocabulary == nullptr || !at('\'')) { return std::nullopt; }
    const std::size_t end = text_.find('\'', position_ + 1);
    if (end == std::string_view::npos) { return std::nullopt; }
    after = end + 1;
    return vocabulary->cores(text_.substr(position_ + 1, end - position_ - 1));
}

bool RendermanEvents::take_registered(CoreSet& cores) {
    std::size_t after = 0;
    const std::optional<CoreSet> found = find_registered(after);
    if (found) {
        cores = *found;
        position_ = after;
    }
    return found.has_value();
}

LabelTest RendermanEvents::parse_labels() {
    at_end();
    const std::size_t opening = position_;
    if (take('.')) { return LabelTest::any(); }
    LabelTest test;
    if (!take('[')) {
        add_label(test);
        return test;
    }
    test.negated = take('^');
    do { add_label(test); } while (!at_end() && !at(']'));
    expect_closing(']', '[', opening);
    return test;
}

void RendermanEvents::add_label(LabelTest& test) {
    if (!at('\'')) { fail_unexpected("expected a quoted label such as 'floor', '.' or [...] of labels"); }
    const std::size_t opening = position_++;
    std::string label;
    while (position_ < text_.size() && text_[position_] != '\'') {
        if (text_[position_] == '\\' && position_ + 1 < text_.size()) { label += text_[position_++]; }
        label += text_[position_++];
    }
    if (position_ >= text_.size()) { source_.fail_at(opening, "the quote is not closed; expected a second '"); }
    ++position_;
    if (!is_glob(label)) {
        test.add_name(std::move(label));
    } else if (label.find_first_of("*?") == std::string::npos) {
        test.add_name(unescaped(label));
    } else if (std::find(test.globs.begin(), test.globs.end(), label) == test.globs.end()) {
        test.globs.push_back(std::move(label));
    }
}

}  // namespace raylex::lpe
