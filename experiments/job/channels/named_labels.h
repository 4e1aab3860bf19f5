// The labels that an expression names, and what each can be about.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A label test of an expression.
struct NamedLabel {
    /// What a label can be of: an object, a lobe of its material, a light's group.
    enum Role : std::uint8_t { object, lobe, group };
    static constexpr std::array<const char*, 3> role_names{"object label", "lobe", "light group"};

    std::string text;
    bool glob = false;
    std::set<Role> roles;
};

/// In the order of the expression, with repetitions.
Result<std::vector<NamedLabel>> labels_of(const lpe::ChannelSource& channel);

/// "; did you mean 'floor'?", or nothing.
std::string did_you_mean(const std::string& label, const std::set<std::string>& candidates);

}  // namespace raylex::experiments
