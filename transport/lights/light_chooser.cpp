#include "transport/lights/light_chooser.h"

#include <algorithm>
#include <utility>

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
        // A tenth of the choices ignores power, so that a weak light close by is chosen often enough.
        weights[i] = even ? 1 : 0.9 * lights[i].power / total + 0.1 / lit;
    }
    table_ = AliasTable(weights);
}

LightChooser LightChooser::by_receiver(std::span<const Light> lights, const EmbreeScene& geometry, LightChoice choice,
                                       std::span<const std::uint8_t> wanted) {
    std::vector<std::uint32_t> placed;
    std::vector<std::uint8_t> others(lights.size(), 0);
    std::size_t other_count = 0;
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
        if (!(lights[i].power > 0) || !(wanted.empty() || wanted[i] != 0)) continue;
        if (lights[i].is_environment() || lights[i].kind == LightKind::distant) others[i] = 1;
        else placed.push_back(i);
    }
    const bool many = placed.size() > most_by_power;
    LightChooser chooser(lights, choice, many ? std::span<const std::uint8_t>(others) : wanted);
    chooser.compensates_ = choice == LightChoice::mis || choice == LightChoice::mis_uniform;
    if (!many) return chooser;
    for (std::uint32_t i = 0; i < lights.size(); ++i) other_count += chooser.table_.probability(i) > 0;
    chooser.table_share_ = static_cast<Real>(other_count) / static_cast<Real>(other_count + 1);
    chooser.tree_ = LightTree(lights, geometry, std::move(placed));
    return chooser;
}

LightTree::Chosen LightChooser::choose_by_receiver(const LightReceiver& receiver, Real u_choice, const Vec2& u) const {
    // A light among 10^5 takes 17 of a float's 24 bits: further bits are hashed from the numbers that place the sample.
    std::uint32_t more = std::bit_cast<std::uint32_t>(to_float(u.x)) * 0x9e3779b9u ^
                         std::bit_cast<std::uint32_t>(to_float(u.y)) * 0x85ebca6bu;
    more = (more ^ (more >> 15)) * 0x2c1b3c6du;
    more = (more ^ (more >> 12)) * 0x297a2d39u;
    const double v = double{u_choice} + double(more ^ (more >> 15)) * 0x1p-56, share = double{table_share_};
    if (v < share) {
        const std::uint32_t light = table_.choose(std::min(static_cast<Real>(v / share), one_minus_epsilon));
        return {light, table_share_ * table_.probability(light)};
    }
    LightTree::Chosen chosen = tree_.choose(receiver, (v - share) / (1 - share));
    chosen.probability *= 1 - table_share_;
    return chosen;
}

}  // namespace raylex::transport
