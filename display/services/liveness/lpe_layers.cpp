// The branches of channels beside a class of paths (lpe_services.h). The class moves first; then its states and shares
// bound those of the channels.
#include <algorithm>
#include <utility>

#include "display/services/samples/branches.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/split_mix.h"

namespace raylex::display {

void Tracker::copy_layers(const Tracker& other) noexcept {
    const Branches from = other.branches_of_layers();
    std::copy_n(from.state, from.count * from.words, layers().state);
    std::copy_n(from.share, from.count, layers().share);
}

void Tracker::divide() {
    layer_groups_ = groups_;
    layer_count_ = count_;
    std::copy_n(state_.data(), layer_groups_, layers().state);
    groups_ = 1;
    whole_ = false;
    share_[0] = layers().share[0] = {1, 1, 1};
}

void Tracker::unite() {
    const auto is_whole = [](const Branches& list) {
        return list.count == 1 && list.share->r == 1 && list.share->g == 1 && list.share->b == 1;
    };
    if (!is_whole(branches_of_main()) || !is_whole(branches_of_layers())) return;
    std::copy_n(layers().state, layer_groups_, state_.data());
    groups_ = std::exchange(layer_groups_, std::uint8_t{0});
    layer_count_ = 0;
    whole_ = true;
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
    tracker.unite();
}

}  // namespace raylex::display
