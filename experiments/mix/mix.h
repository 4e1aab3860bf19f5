// Factors for lights and for colours of objects, from the command line or from a TOML file:
//
//   [light]                       # light groups: one factor, or one each for red, green and blue
//   key = 2
//   fill = [1, 0.8, 0.6]
//   rim = "-1.5 stops"
//   [what_if]                     # colours of labelled objects, for atlases only
//   "wall.D" = [0.5, 0.2, 0.2]
#pragma once

#include <array>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A factor for red, green and blue.
struct ColorFactor {
    std::string name;  ///< a light group or a layer, or an object and a lobe: "wall.D"
    std::array<double, 3> rgb{1, 1, 1};
    SourceLocation where;

    [[nodiscard]] bool is_one() const { return rgb == std::array<double, 3>{1, 1, 1}; }
    [[nodiscard]] bool is_grey() const { return rgb[0] == rgb[1] && rgb[1] == rgb[2]; }
};

struct Mix {
    std::vector<ColorFactor> lights, colors;
};

/// Adds factors from texts "NAME=FACTOR". FACTOR is a number of at least 0 ("2"), three of them ("1,0.8,0.6"), or an
/// exposure in stops ("+1stop", "-0.5 stops"). `option` names the option in errors.
Status add_factors(const std::vector<std::string>& texts, const std::string& option, std::vector<ColorFactor>& to);

/// Adds the factors of a file. Errors: not such a file; an unknown table; an invalid factor.
Status read_mix(const std::string& path, Mix& mix);

/// Returns the factors as text for a header: "key=2,2,2 fill=1,0.8,0.6".
std::string factors_text(const std::vector<ColorFactor>& factors);

/// Checks that no name occurs twice.
Status check_once(const std::vector<ColorFactor>& factors);

}  // namespace raylex::experiments
