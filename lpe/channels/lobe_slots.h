// RenderMan's numbered lobes are slots that options fill by name: with `lpe:diffuse2 = "Diffuse,HairDiffuse"`, every
// diffuse lobe of these names is D2. A lobe whose name is in no slot has no number (0).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/channels/channel_file.h"
#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// One slot and the lobe names in it.
struct LobeSlot {
    std::string_view name;   ///< "diffuse2"
    std::string_view names;  ///< "Diffuse,HairDiffuse"
};

/// The defaults: RenderMan's published ones, plus the names of raylex's own materials (lpe/README.md, event table).
[[nodiscard]] std::span<const LobeSlot> default_lobe_slots();

class LobeSlots {
  public:
    LobeSlots();  ///< starts with the default slots

    /// Replaces the names in a slot ("diffuse2" or "lpe:diffuse2": diffuse1-4, specular1-8, user1-12). An empty list
    /// empties the slot. Errors, with the position of the option: no such slot, a lobe name in two slots of a kind.
    Status set(const LobeOption& option);

    /// The D, S or U number of a lobe; 0 when no slot contains it. Slots that were set take precedence over defaults.
    [[nodiscard]] std::uint8_t number(Scatter scatter, std::string_view lobe) const;
    [[nodiscard]] std::uint8_t user_number(std::string_view lobe) const;

    /// Slot and names of every slot that was set, in order: the difference from the defaults.
    [[nodiscard]] std::vector<std::pair<std::string, std::string>> settings() const;

  private:
    enum Kind : std::uint8_t { diffuse, specular, user };
    struct Slot {
        std::vector<std::string> names;
        bool set = false;
        std::string text;
    };
    [[nodiscard]] std::uint8_t find(Kind kind, std::string_view lobe) const;
    std::array<std::map<int, Slot>, 3> slots_;
};

}  // namespace raylex::lpe
