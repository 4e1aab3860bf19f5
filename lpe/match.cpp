#include "lpe/match.h"

#include <array>

#include "lpe/language/pattern.h"
#include "lpe/program.h"

namespace raylex::lpe {

namespace {

class EventReader {
  public:
    explicit EventReader(std::string_view text) : text_(text) {}

    Result<PlacedEvents> run() {
        PlacedEvents events;
        for (;;) {
            while (position_ < text_.size() && is_blank(text_[position_])) { ++position_; }
            if (position_ >= text_.size()) { return events; }
            const std::size_t offset = position_;
            Event event;
            if (!read_type(event) || !read_scatter(event) || !read_labels(event)) { return std::move(error_); }
            events.events.push_back(std::move(event));
            events.offsets.push_back(offset);
        }
    }

  private:
    [[nodiscard]] bool at(char c) const { return position_ < text_.size() && text_[position_] == c; }
    [[nodiscard]] bool at_word_end() const { return position_ >= text_.size() || is_blank(text_[position_]); }

    bool refuse(std::size_t offset, const std::string& expected) {
        error_.message = "found ";
        if (offset < text_.size()) {
            error_.message += '\'';
            error_.message += text_[offset];
            error_.message += '\'';
        } else {
            error_.message += "the end of the events";
        }
        error_.message += "; expected ";
        error_.message += expected;
        error_.line = 1;
        error_.column = static_cast<int>(offset) + 1;
        error_.excerpt = std::string(text_);
        error_.hint = "an event is type,scatter[,label...], as in C,- R,D,floor L,-,key";
        return false;
    }

    bool read_number(int highest, std::uint8_t& number) {
        const std::size_t begin = position_;
        int value = 0;
        while (position_ < text_.size() && text_[position_] >= '0' && text_[position_] <= '9' && value <= highest) {
            value = 10 * value + (text_[position_++] - '0');
        }
        if (position_ > begin && (value < 1 || value > highest)) {
            return refuse(begin, "a lobe number from 1 to " + std::to_string(highest));
        }
        number = static_cast<std::uint8_t>(value);
        return true;
    }

    bool read_type(Event& event) {
        const std::size_t offset = position_;
        constexpr std::string_view letters = "CRTVLBO";
        const std::size_t type = letters.find(text_[position_]);
        if (type != std::string_view::npos) {
            ++position_;
            event.type = static_cast<EventType>(type);
        } else if (text_[position_] == 'U') {
            ++position_;
            event.type = EventType::user;
            if (!read_number(12, event.lobe_number)) { return false; }
            if (event.lobe_number == 0) { return refuse(position_, "the number of the user event, U1 to U12"); }
        } else {
            return refuse(offset, "an event type: C R T V L B O or U1 to U12");
        }
        if (!at(',')) { return refuse(position_, "',' and the scattering"); }
        ++position_;
        return true;
    }

    bool read_scatter(Event& event) {
        constexpr std::string_view letters = "-DGSs";
        const std::size_t scatter = position_ < text_.size() ? letters.find(text_[position_]) : std::string_view::npos;
        if (scatter == std::string_view::npos) { return refuse(position_, "a scattering: D G S s, or '-' for none"); }
        if (event.type == EventType::user && static_cast<Scatter>(scatter) != Scatter::none) {
            return refuse(position_, "'-': a user event has no scattering");  // the number is part of the event
        }
        ++position_;
        event.scatter = static_cast<Scatter>(scatter);
        if (event.scatter != Scatter::none && event.scatter != Scatter::straight) {
            return read_number(event.scatter == Scatter::diffuse ? 4 : 8, event.lobe_number);
        }
        return true;
    }

    bool read_labels(Event& event) {
        while (at(',')) {
            ++position_;
            std::string label;
            const char quote = at('\'') || at('"') ? text_[position_] : '\0';
            if (quote == '\0') {
                while (!at_word_end() && !at(',')) { label += text_[position_++]; }
            } else if (!read_quoted(quote, label)) {
                return false;
            }
            event.labels.push_back(std::move(label));
        }
        return at_word_end() || refuse(position_, "',' and a label, or a blank and the next event");
    }

    bool read_quoted(char quote, std::string& label) {
        const std::size_t opening = position_++;
        while (position_ < text_.size() && text_[position_] != quote) {
            if (text_[position_] == '\\' && position_ + 1 < text_.size()) { ++position_; }
            label += text_[position_++];
        }
        if (position_ >= text_.size()) { return refuse(opening, "a second quote that closes this one"); }
        ++position_;
        return true;
    }

    std::string_view text_;
    std::size_t position_ = 0;
    Error error_;
};

std::string quoted_if_needed(const std::string& label) {
    if (label.find_first_of(" \t\r\n,'\"\\") == std::string::npos) { return label; }
    std::string text = "'";
    for (const char c : label) {
        if (c == '\'' || c == '\\') { text += '\\'; }
        text += c;
    }
    return text + "'";
}

std::string label_at(const Event& event, std::size_t slot) {
    return slot < event.labels.size() && !event.labels[slot].empty() ? "'" + event.labels[slot] + "'" : "";
}

std::string scatter_words(const Event& event) {
    constexpr std::array<std::string_view, scatter_kinds> names{"", "diffuse ", "glossy ", "specular ", "straight "};
    return std::string(names[static_cast<std::size_t>(event.scatter)]);
}

std::string event_words(const Event& event) {
    const std::string first = label_at(event, 0);
    const auto with = [&first](const std::string& text, const std::string& link) {
        return first.empty() ? text : text + link + first;
    };
    std::string text;
    switch (event.type) {
        case EventType::camera:
            return with("camera", " ");
        case EventType::light:
            return with("light", " ");
        case EventType::background:
            return with("background", " ");
        case EventType::emission:
            return with("emission", " ");
        case EventType::user:
            return with("user event U" + std::to_string(event.lobe_number), " ");
        case EventType::volume:
            text = with("volume scattering", " in ");
            break;
        case EventType::reflection:
            text = with(scatter_words(event) + "reflection", " off ");
            break;
        case EventType::transmission:
            text = with(scatter_words(event) + "transmission", " through ");
            break;
    }
    std::string details;
    if (event.lobe_number > 0) { details = "lobe number " + std::to_string(event.lobe_number); }
    const std::string lobe = label_at(event, 1);
    if (!lobe.empty()) {
        details += details.empty() ? "lobe " : ", lobe ";
        details += lobe;
    }
    return details.empty() ? text : text + " (" + details + ")";
}

}  // namespace

Result<PlacedEvents> parse_placed_events(std::string_view text) {
    return EventReader(text).run();
}

Result<std::vector<Event>> parse_events(std::string_view text) {
    Result<PlacedEvents> placed = EventReader(text).run();
    if (!placed) { return std::move(placed).error(); }
    return std::move(placed->events);
}

std::string to_text(const Event& event) {
    std::string text;
    if (event.type == EventType::user) {
        text = 'U';
        text += std::to_string(event.lobe_number);
        text += ",-";
    } else {
        text = type_letter(event.type);
        text += ',';
        text += event.scatter == Scatter::none ? '-' : scatter_letter(event.scatter);
        if (event.lobe_number > 0) { text += std::to_string(event.lobe_number); }
    }
    for (std::size_t slot = 0; slot < label_count(event); ++slot) {
        text += ',';
        text += quoted_if_needed(event.labels[slot]);
    }
    return text;
}

std::string to_text(std::span<const Event> events) {
    std::string text;
    for (const Event& event : events) {
        text += text.empty() ? "" : " ";
        text += to_text(event);
    }
    return text;
}

std::string to_sentence(const Event& event) {
    return event_words(event);
}

std::string to_sentence(std::span<const Event> events) {
    std::string text;
    for (const Event& event : events) {
        text += text.empty() ? "" : ", ";
        text += event_words(event);
    }
    return text;
}

Result<bool> match(std::string_view expression, std::span<const Event> events, Dialect dialect) {
    ChannelSource source;
    source.expression = std::string(expression);
    source.dialect = dialect;
    Result<Program> program = Program::compile({&source, 1}, {.any_path_string = true});
    if (!program) { return std::move(program).error(); }
    State state = program->starts().front();
    for (const Event& event : events) { state = program->next(state, program->classify(event)); }
    return program->accepts_any(state);
}

}  // namespace raylex::lpe
