#include "experiments/report/denoised_text.h"

#include <algorithm>
#include <cmath>

#include "experiments/program/columns.h"
#include "experiments/program/console.h"

namespace raylex::experiments {

std::vector<std::string> denoised_text(const display::DenoisedImage& denoised) {
    std::size_t width = 5;
    for (const display::DenoisedLayer& layer : denoised.layers) width = std::max(width, layer.name.size());
    std::vector<std::string> lines{padded("layer", width) + "  root mean squared error, estimated"};
    for (const auto& [name, error] : denoised.layers) {
        std::string line = padded(name, width) + "  " + padded(number_text(std::sqrt(error.before)), 9) + "-> " +
                           number_text(std::sqrt(error.after)) + " (95 %: " + number_text(std::sqrt(error.least)) +
                           " to " + number_text(std::sqrt(error.most)) + ")";
        if (const double change = error.light_after - error.light; change != 0 && error.light != 0)
            line += std::string("; light ") + (change < 0 ? "removed: " : "added: ") +
                    number_text(100 * std::abs(change / error.light), 2) + " %";
        lines.push_back(std::move(line));
    }
    if (denoised.has_overscan) lines.emplace_back("pixels outside the display window (overscan) are not denoised");
    return lines;
}

}  // namespace raylex::experiments
