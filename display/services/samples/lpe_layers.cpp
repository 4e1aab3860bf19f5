// The branches of channels beside a class of paths (lpe_services.h). The class moves first; then its states and shares
// bound those of the channels.
#include <algorithm>

#include "display/services/samples/branches.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/split_mix.h"

namespace raylex::display {

void Tracker::copy_layers(const Tracker& other) noexcept {
    const Branches from = other.branches_of_layers();
    std::copy_n(from.state, from.count * from.words, layers().state);
    std::copy_n(from.share, from.count, layers().share);
}

Tracker LpeServices::begin_layers(int row) const {
    Tracker tracker;
    tracker.row_ = row;
    tracker.groups_ = tracker.count_ = tracker.layer_count_ = 1;
    tracker.layer_groups_ = static_cast<std::uint8_t>(setup_.first_layer_states_.size());
    tracker.whole_ = false;
    tracker.main().share[0] = tracker.layers().share[0] = {1, 1, 1};
    tracker.state_[0] = setup_.first_states_[0];
    std::copy(setup_.first_layer_states_.begin(), setup_.first_layer_states_.end(), tracker.layers().state);
    return tracker;
}

void LpeServices::split_layers(Tracker& tracker, std::span<const LobePart> parts, const Fractions& fractions,
                               const Branches& of_class) {
    if (of_class.count == 0) {
        tracker.layer_count_ = 0;
        return;
    }
    ChoiceNumbers numbers([&] { return mix_bits(random_key(tracker, parts[0])); });
    BranchList branches(tracker.layer_groups_, true);
    branches.split(tracker.branches_of_layers(), parts, fractions, Tracker::layer_capacity, numbers,
                   [&](const lpe::State* from, lpe::EventClass event, lpe::State* to) {
                       return setup_.program_.view().advance(from, event, to) && of_class.has_state(to[0]);
                   });
    branches.fit(of_class);
    put(tracker.layers(), branches);
}

void LpeServices::contribute_to_layers(const SampleTable::Light& light, const Tracker& tracker) {
    const Branches layers = tracker.branches_of_layers();
    for (std::size_t branch = 0; branch < layers.count; ++branch) {
        SampleTable::Light part = light;
        scale(part, layers.share[branch]);
        splat_branch(setup_.program_.view(), layers.state_of(branch), 1, part, tracker.row_);
    }
}

}  // namespace raylex::display
