#include "lpe/adopt/vocabulary.h"

#include <utility>

#include "lpe/language/source_text.h"

namespace raylex::lpe {

namespace {

constexpr int user_events = 12, diffuse_lobes = 4, specular_lobes = 8;

Error error_of(std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    return error;
}

}  // namespace

Status Vocabulary::check_name(const std::string& name) const {
    if (name.empty() || name == "." || name.find_first_of("'\"\\*?") != std::string::npos) {
        return error_of("'" + name +
                        "' cannot be the name of an event or lobe; expected text without quotes, '\\', '*' and '?'");
    }
    if (entries_.count(name) != 0) { return error_of("the name '" + name + "' is already registered"); }
    return success();
}

Result<int> Vocabulary::add_event(const std::string& name) {
    std::vector<bool> taken(user_events + 1, false);
    for (const auto& [other, entry] : entries_) {
        taken[static_cast<std::size_t>(entry.scatter == Scatter::none ? entry.number : 0)] = true;
    }
    for (int number = 1; number <= user_events; ++number) {
        if (!taken[static_cast<std::size_t>(number)]) {
            const Status status = add_event(name, number);
            return status ? Result<int>(number) : Result<int>(status.error());
        }
    }
    return error_of("no user event is left for '" + name + "': " + std::to_string(user_events) + " are registered");
}

Status Vocabulary::add_event(const std::string& name, int number) {
    if (Status status = check_name(name); !status) { return status; }
    if (number < 1 || number > user_events) {
        return error_of("user event U" + std::to_string(number) + ", for '" + name +
                        "', does not exist; expected U1 to U12");
    }
    entries_.emplace(name, Entry{Scatter::none, number});
    return success();
}

Status Vocabulary::add_lobe(const std::string& name, Scatter scatter, int number) {
    if (Status status = check_name(name); !status) { return status; }
    if (scatter == Scatter::none || scatter == Scatter::straight) {
        return error_of("the lobe '" + name + "' must be diffuse, glossy or singular");
    }
    const int most = scatter == Scatter::diffuse ? diffuse_lobes : specular_lobes;
    if (number < 1 || number > most) {
        const std::string letter = scatter == Scatter::diffuse ? "D" : "S";
        return error_of("lobe " + letter + std::to_string(number) + ", for '" + name + "', does not exist; expected " +
                        letter + "1 to " + letter + std::to_string(most));
    }
    entries_.emplace(name, Entry{scatter, number});
    return success();
}

std::optional<CoreSet> Vocabulary::cores(std::string_view name) const {
    const auto place = entries_.find(name);
    if (place == entries_.end()) { return std::nullopt; }
    const Entry& entry = place->second;
    const auto number = static_cast<std::uint8_t>(entry.number);
    CoreSet cores;
    if (entry.scatter == Scatter::none) {
        cores.set(core_index({EventType::user, Scatter::none, number, {}}));
        return cores;
    }
    for (int type = 0; type < scene_types; ++type) {
        if (entry.scatter == Scatter::diffuse) {
            cores.set(core_index({static_cast<EventType>(type), Scatter::diffuse, number, {}}));
        } else {
            cores.set(core_index({static_cast<EventType>(type), Scatter::glossy, number, {}}));
            cores.set(core_index({static_cast<EventType>(type), Scatter::singular, number, {}}));
        }
    }
    return cores;
}

bool Vocabulary::is_event(std::string_view name) const {
    const auto place = entries_.find(name);
    return place != entries_.end() && place->second.scatter == Scatter::none;
}

Error Vocabulary::unknown(std::string_view name, bool event) const {
    std::vector<std::string_view> names;
    for (const auto& [known, entry] : entries_) {
        if ((entry.scatter == Scatter::none) == event) { names.push_back(known); }
    }
    const std::string near = nearest(name, names.data(), names.size());
    return error_of("no " + std::string(event ? "event" : "lobe") + " is registered as '" + std::string(name) + "'",
                    near.empty() ? "" : "did you mean '" + near + "'?");
}

Result<Event> Vocabulary::event(std::string_view name, std::vector<std::string> labels) const {
    const auto place = entries_.find(name);
    if (place == entries_.end() || place->second.scatter != Scatter::none) { return unknown(name, true); }
    return Event{EventType::user, Scatter::none, static_cast<std::uint8_t>(place->second.number), std::move(labels)};
}

Result<Event> Vocabulary::scattering(EventType type, std::string_view lobe, std::vector<std::string> labels) const {
    const auto place = entries_.find(lobe);
    if (place == entries_.end() || place->second.scatter == Scatter::none) { return unknown(lobe, false); }
    return Event{type, place->second.scatter, static_cast<std::uint8_t>(place->second.number), std::move(labels)};
}

}  // namespace raylex::lpe
