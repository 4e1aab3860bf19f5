#include "lpe/channels/lobe_slots.h"

#include <algorithm>
#include <utility>

#include "lpe/language/source_text.h"

namespace raylex::lpe {

namespace {

// Sources: capitalised names are from RenderMan documentation, "Light Path Expressions", section Per-Lobe LPEs (REN26).
// Lower-case names (translucent, hair1, ...) are for Lama's materials, from the published defaults of these options in
// RenderMan for Blender and Gaffer; there "specular" is in slots 2 and 8, and the lower slot wins. The last names of a
// line are raylex's lobes: conductor, mirror, sheet, R, measured, TRT, TRRT, coat, TT, glass, albedo, normal.
constexpr std::array<LobeSlot, 13> default_table{{
    {"diffuse2", "Diffuse,HairDiffuse,diffuse,translucent,hair4,irradiance"},
    {"diffuse3", "Subsurface,subsurface"},
    {"specular2", "Specular,HairSpecularR,specular,hair1,conductor,mirror,sheet,R,measured"},
    {"specular3", "RoughSpecular,HairSpecularTRT,hair3,TRT,TRRT"},
    {"specular4", "Clearcoat,coat"},
    {"specular5", "Iridescence"},
    {"specular6", "Fuzz,HairSpecularGLINTS"},
    {"specular7", "SingleScatter,HairSpecularTT,hair2,TT"},
    {"specular8", "Glass,specular,glass"},
    {"user2", "Albedo,DiffuseAlbedo,SubsurfaceAlbedo,HairAlbedo,albedo"},
    {"user3", "Position"},
    {"user4", "UserColor"},
    {"user6",
     "Normal,DiffuseNormal,HairTangent,SubsurfaceNormal,SpecularNormal,RoughSpecularNormal,SingleScatterNormal,"
     "FuzzNormal,IridescenceNormal,GlassNormal,normal"},
}};

constexpr std::array<std::string_view, 3> kind_names{"diffuse", "specular", "user"};
constexpr std::array<int, 3> highest{4, 8, 12};

/// Splits names at commas and removes surrounding blanks.
std::vector<std::string> split_names(std::string_view text) {
    std::vector<std::string> names;
    while (!text.empty()) {
        const std::size_t comma = std::min(text.find(','), text.size());
        std::string_view name = text.substr(0, comma);
        text.remove_prefix(std::min(comma + 1, text.size()));
        const std::size_t begin = name.find_first_not_of(" \t");
        if (begin != std::string_view::npos) {
            name = name.substr(begin, name.find_last_not_of(" \t") - begin + 1);
            names.emplace_back(name);
        }
    }
    return names;
}

struct SlotPlace {
    std::size_t kind = 0;
    int number = 0;  // 0: no such slot
};

SlotPlace place_of_slot(std::string_view name) {
    for (std::size_t kind = 0; kind < kind_names.size(); ++kind) {
        if (!name.starts_with(kind_names[kind])) { continue; }
        const std::string_view digits = name.substr(kind_names[kind].size());
        for (int number = 1; number <= highest[kind]; ++number) {
            if (digits == std::to_string(number)) { return {kind, number}; }
        }
    }
    return {};
}

Error error_about(const LobeOption& option, std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    error.file = option.origin;
    error.line = option.line;
    error.column = option.column;
    return error;
}

}  // namespace

std::span<const LobeSlot> default_lobe_slots() {
    return default_table;
}

LobeSlots::LobeSlots() {
    for (const LobeSlot& entry : default_table) {
        const SlotPlace place = place_of_slot(entry.name);
        slots_[place.kind][place.number].names = split_names(entry.names);
    }
}

Status LobeSlots::set(const LobeOption& option) {
    std::string_view name = option.slot;
    name.remove_prefix(name.starts_with("lpe:") ? 4 : 0);
    const SlotPlace place = place_of_slot(name);
    if (place.number == 0) {
        std::vector<std::string> all;
        for (std::size_t kind = 0; kind < kind_names.size(); ++kind) {
            for (int number = 1; number <= highest[kind]; ++number) {
                all.push_back(std::string(kind_names[kind]) + std::to_string(number));
            }
        }
        const std::vector<std::string_view> candidates(all.begin(), all.end());
        const std::string near = nearest(name, candidates.data(), candidates.size());
        return error_about(option,
                           "no lobe slot '" + std::string(name) +
                               "'; expected diffuse1 to diffuse4, specular1 to specular8 or user1 to user12",
                           near.empty() ? "" : "did you mean '" + near + "'?");
    }
    std::vector<std::string> names = split_names(option.names);
    for (const auto& [number, slot] : slots_[place.kind]) {
        for (const std::string& each : names) {
            if (slot.set && number != place.number &&
                std::find(slot.names.begin(), slot.names.end(), each) != slot.names.end()) {
                return error_about(option, "the lobe '" + each + "' is in " + std::string(kind_names[place.kind]) +
                                               std::to_string(number) + " already; expected it in one slot");
            }
        }
    }
    slots_[place.kind][place.number] = {std::move(names), true, option.names};
    return success();
}

std::uint8_t LobeSlots::find(Kind kind, std::string_view lobe) const {
    for (const bool set : {true, false}) {
        for (const auto& [number, slot] : slots_[kind]) {
            if (slot.set == set && std::find(slot.names.begin(), slot.names.end(), lobe) != slot.names.end()) {
                return static_cast<std::uint8_t>(number);
            }
        }
    }
    return 0;
}

std::uint8_t LobeSlots::number(Scatter scatter, std::string_view lobe) const {
    switch (scatter) {
        case Scatter::diffuse:
            return find(diffuse, lobe);
        case Scatter::glossy:
        case Scatter::singular:
            return find(specular, lobe);
        default:
            return 0;
    }
}

std::uint8_t LobeSlots::user_number(std::string_view lobe) const {
    return find(user, lobe);
}

std::vector<std::pair<std::string, std::string>> LobeSlots::settings() const {
    std::vector<std::pair<std::string, std::string>> result;
    for (std::size_t kind = 0; kind < kind_names.size(); ++kind) {
        for (const auto& [number, slot] : slots_[kind]) {
            if (slot.set) { result.emplace_back(std::string(kind_names[kind]) + std::to_string(number), slot.text); }
        }
    }
    return result;
}

}  // namespace raylex::lpe
