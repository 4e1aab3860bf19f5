#include <cmath>

#include "display/output/reader/exr_layers.h"
#include "experiments/mix/image_mix.h"
#include "experiments/program/console.h"

namespace raylex::experiments {

std::vector<std::string> mix_notes(const MixedImage& mixed) {
    std::vector<std::string> notes;
    if (!mixed.is_proved)
        notes.push_back("the header declares no partition with " + display::list_names(mixed.scaled) +
                        "; the layers are taken for disjoint parts of the beauty");
    for (const std::string& each : mixed.left_out)
        notes.push_back(each + " is left out: its light does not follow the factors");
    constexpr double visible = 1e-4;
    if (mixed.is_whole && std::abs(mixed.unassigned) > visible)
        notes.push_back(number_text(100 * mixed.unassigned) + " % of the beauty is in no layer; it is kept as it is");
    return notes;
}

}  // namespace raylex::experiments
