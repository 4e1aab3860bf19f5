// Lists the labels in an expression and their possible roles.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A test for a label in an expression.
struct NamedLabel {
    /// The role of a label: an object, a lobe of its material, or a light's group.
    enum Role : std::uint8_t { object, lobe, group };
    static constexpr std::array<const char*, 3> role_names{"object label", "lobe", "light group"};

    std::string text;
    bool glob = false;
    std::set<Role> roles;
};

/// Returns the labels in the order of the expression, with repetitions.
Result<std::vector<NamedLabel>> labels_of(const lpe::ChannelSource& channel);

/// Returns "; did you mean 'floor'?", or an empty string.
std::string did_you_mean(const std::string& label, const std::set<std::string>& candidates);

}  // namespace raylex::experiments
