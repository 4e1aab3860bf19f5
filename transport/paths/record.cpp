#include "transport/paths/record.h"

#include <utility>

namespace raylex::transport {

LightLanguage::LightLanguage(const display::LpeSetup& setup, const EventTable& events)
    : events_(&events), keeps_paths_(setup.words() != nullptr), prunes_(setup.beauty() < 0 && events.prunes()) {
    if (Result<lpe::ReversedProgram> reversed = lpe::ReversedProgram::build(setup.main()))
        reversed_.emplace(std::move(*reversed));
    if (prunes_) liveness_ = display::SuffixLiveness(setup, this->reversed(), events.alphabet());
    has_layers_ = setup.has_layers() && reversed_;
    if (!has_layers_) return;
    if (Result<lpe::ReversedProgram> all = lpe::ReversedProgram::build(setup.program()))
        reversed_layers_.emplace(std::move(*all));
}

display::PathSuffixes LightLanguage::pool() const {
    display::PathSuffixes pool(reversed(), keeps_paths_);
    if (has_layers_) pool.add_layers(reversed_layers_ ? &*reversed_layers_ : nullptr);
    return pool;
}

display::SuffixLiveness::LiveSet LightLanguage::live_set_of(lpe::EventClass terminal) const {
    const display::Liveness& forward = events_->liveness();
    // Beauty takes every light: this is for channels alone.
    if (prunes_ && (forward.live_terminals() & forward.bit_of(terminal)) == 0) return {false, false, false};
    return liveness_.of(terminal);
}

display::Liveness::LiveSet Record::live_set_of_channels(std::uint32_t row, std::int32_t label,
                                                        std::int32_t material) const {
    if (!is_followed(row)) return {0, false, false};
    return events_->liveness().after(trackers_[row], events_->scatterings(label, material));
}

bool Record::is_live_in_medium(std::uint32_t row, std::int32_t medium) const {
    return takes_all(row) || is_live_lobe(row, events_->medium_label(medium), 0);
}

Record::Liveness Record::liveness_of_connection(std::uint32_t row, std::int32_t label, const LobeList& lobes,
                                                std::uint32_t light, const LightEnd* end, bool cutouts) const {
    display::Tracker ahead = after(row, label, lobes);
    if (cutouts) return lpe_->live(ahead) ? Liveness::if_visible : Liveness::dead;
    if (end != nullptr) reach(ahead, *end);
    else reach_light(ahead, light);
    if (!lpe_->live(ahead)) return Liveness::dead;
    const bool needs_ray = !lpe_->wants_emitter_samples() || lpe_->needs_visibility(ahead);
    return needs_ray ? Liveness::if_visible : Liveness::if_visible_or_not;
}

bool Record::is_live_splat(std::uint32_t row, const LightEnd& end) const {
    display::Tracker tracker = lpe_->begin(static_cast<int>(row));
    if (!events_->prunes()) return true;
    reach(tracker, end);
    return lpe_->channels_follow(tracker);
}

}  // namespace raylex::transport
