#include "transport/lights/light_chooser.h"

namespace raylex::transport {

LightChooser::LightChooser(std::span<const Light> lights, LightChoice choice, std::span<const std::uint8_t> wanted) {
    const bool leaves_skies = choice == LightChoice::mis || choice == LightChoice::mis_uniform;
    const bool even = choice == LightChoice::mis_uniform || choice == LightChoice::light_sampling_uniform;
    double total = 0, lit = 0;
    const auto lights_up = [&](std::size_t i) { return lights[i].power > 0 && (wanted.empty() || wanted[i] != 0); };
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!lights_up(i)) continue;
        total += lights[i].power;
        lit += 1;
    }
    std::vector<double> weights(lights.size(), 0.0);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!lights_up(i) || (leaves_skies && lights[i].kind == LightKind::uniform_environment)) continue;
        // A tenth of the choices ignores power: a weak light close by is never starved.
        weights[i] = even ? 1 : 0.9 * lights[i].power / total + 0.1 / lit;
    }
    table_ = AliasTable(weights);
}

}  // namespace raylex::transport
