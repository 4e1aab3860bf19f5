// The record of paths: the one place that calls the LPE services.
//
// A record keeps one tracker for each camera subpath. Walks and integrators report events to the record (a scattering
// by these lobes, the arrival at a light) and read two results: whether the path is live, and whether a connection is
// live. Channels, their liveness (Law 4), the shares of lobes (Law 5), prefixes and holdouts are handled only in the
// record and the services.
//
// Paths that begin at a light are recorded in the order in which the camera would have met them: a light record puts
// each vertex before the earlier ones, and a connection leads a camera subpath along that suffix to the light.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "display/services/liveness/path_suffix.h"
#include "display/services/liveness/suffix_liveness.h"
#include "display/services/samples/lpe_services.h"
#include "transport/lights/light_table.h"
#include "transport/paths/event_table.h"
#include "transport/paths/scattering.h"

namespace raylex::transport {

/// The light end of a connection: a vertex of a light subpath.
struct LightEnd {
    std::int32_t label = 0;
    LobeList lobes;  ///< of the scattering there towards the camera's side
    const display::PathSuffixes* words = nullptr;
    display::PathSuffix word;  ///< the path suffix from the vertex to the light; valid until the next batch
};

/// Light that a path brings to the camera, found by one technique.
struct Arrival {
    Rgb value{};          ///< contribution to beauty, with the MIS weight
    Rgb emitted{};        ///< radiance that leaves the emitter towards the path
    Rgb unweighted{};     ///< `value` without the MIS weight and without `visibility`
    Real visibility = 1;  ///< fraction that surfaces on the way let pass: 0 behind an opaque one
    /// A light sample could find this light too, and another technique found it. False for light samples.
    bool sampled_too = false;
};

using LobeParts = std::array<display::LobePart, max_lobes>;
/// The lobes of a scattering as the services take them.
inline std::span<const display::LobePart> lobe_parts(const EventTable& events, std::int32_t label,
                                                     const LobeList& lobes, LobeParts& parts) {
    const auto count = static_cast<std::size_t>(lobes.count);
    for (std::size_t i = 0; i < count; ++i)
        parts[i] = {events.scatter(label, lobes.entry[i].lobe), to_float(lobes.entry[i].value)};
    return {parts.data(), count};
}

class Record {
  public:
    /// `rows` is the number of camera subpaths; records of splats have none.
    explicit Record(const EventTable& events, std::size_t rows = 0) : events_(&events), trackers_(rows) {}

    /// Moves rows [0, count) to the camera.
    void begin(display::LpeServices& lpe, std::size_t count) {
        lpe_ = &lpe;
        for (std::size_t row = 0; row < count; ++row) trackers_[row] = lpe.begin(static_cast<int>(row));
    }
    /// For records without rows: sets the services to report to.
    void begin(display::LpeServices& lpe) { lpe_ = &lpe; }

    // Events of the camera subpath of a row. `label` is that of an object, or EventTable::medium_label().
    void scatter(std::uint32_t row, std::int32_t label, const LobeList& lobes) {
        scatter(trackers_[row], label, lobes);
    }
    void pass_through(std::uint32_t row, std::int32_t label) { pass_through(trackers_[row], label); }
    /// Marks the subpath's first hit as a holdout.
    void hold_out(std::uint32_t row) { lpe_->hold_out(trackers_[row]); }
    /// Reports light of an emitter that the subpath has reached. `terminal` is the event of the emitter.
    void arrive(std::uint32_t row, lpe::EventClass terminal, display::Technique technique,
                const Arrival& arrival) const;
    /// Counts and logs a subpath whose throughput is NaN or infinite (Law 6).
    void reject(std::uint32_t row, const Rgb& throughput) const {
        lpe_->contribute(to_float(throughput), {}, trackers_[row]);
    }
    /// Reports a user event of the surface. Calls `value()` only if a channel takes it. `throughput` is that of the
    /// path to the surface.
    template <class Value>
    void report_user(std::uint32_t row, std::int32_t label, UserLobe lobe, const Rgb& throughput, Value value) const;

    /// Whether the subpath can still find light that a channel takes.
    [[nodiscard]] bool is_live(std::uint32_t row) const {
        return takes_all(row) || (is_followed(row) && events_->liveness().of(trackers_[row]).anything);
    }
    /// What channels can still take after the subpath is scattered at the vertex, by any lobe of its material.
    [[nodiscard]] display::Liveness::LiveSet live_set(std::uint32_t row, std::int32_t label,
                                                      std::int32_t material) const {
        return takes_all(row) ? display::Liveness::LiveSet() : live_set_of_channels(row, label, material);
    }
    /// Whether the subpath can find light that a channel takes, at its vertex or later, by any lobe of the material
    /// there.
    [[nodiscard]] bool is_live(std::uint32_t row, std::int32_t label, std::int32_t material) const {
        return live_set(row, label, material).anything;
    }
    /// Whether the subpath can find light that a channel takes after this lobe scatters it at its vertex.
    [[nodiscard]] bool is_live_lobe(std::uint32_t row, std::int32_t label, LobeId lobe) const {
        const lpe::EventClass event = events_->scatter(label, lobe);
        return is_followed(row) && events_->liveness().after(trackers_[row], {&event, 1}).anything;
    }
    /// Whether the subpath can find light that a channel takes after a scattering in this medium.
    [[nodiscard]] bool is_live_in_medium(std::uint32_t row, std::int32_t medium) const;
    /// True if beauty takes the whole path, or if pruning is off, except where follow_beauty_alone() ends the path.
    /// Then is_live() is true as well.
    [[nodiscard]] bool takes_all(std::uint32_t row) const {
        return lpe_->takes_all(trackers_[row]) || !(events_->prunes() || is_dropped(row));
    }
    /// With `alone`, subpaths that are held out end, whatever channels take. No beauty and no class of paths takes
    /// their light.
    void follow_beauty_alone(bool alone) { beauty_alone_ = alone; }
    /// Whether a channel other than beauty can take light of the subpath.
    [[nodiscard]] bool channels_follow(std::uint32_t row) const { return lpe_->channels_follow(trackers_[row]); }
    /// Whether blocked light must be reported too.
    [[nodiscard]] bool wants_blocked_light() const { return lpe_->wants_emitter_samples(); }

    /// Whether values must not depend on which other channels are requested, although there is no beauty: channels of
    /// blocked light then have the same bits with and without it.
    [[nodiscard]] bool counts_alike() const { return lpe_->wants_emitter_samples() && !lpe_->is_of_class(); }

    enum class Liveness : std::uint8_t {
        dead,              ///< no channel takes the connection
        if_visible,        ///< some channel takes what arrives: trace a shadow ray
        if_visible_or_not  ///< channels take it whatever is in the way: report it without a ray
    };
    /// Whether a channel takes a connection of a row's subpath, scattered at its vertex by these lobes, to a light or
    /// to `end`. Only for rows of which beauty does not take everything. `cutouts`: the connection may pass cutouts,
    /// which leave events of their own.
    [[nodiscard]] Liveness liveness_of_connection(std::uint32_t row, std::int32_t label, const LobeList& lobes,
                                                  std::uint32_t light, const LightEnd* end, bool cutouts) const;
    /// Whether a channel takes the connection of `end` to the camera.
    [[nodiscard]] bool is_live_splat(std::uint32_t row, const LightEnd& end) const;

    void hold_out(display::Tracker& tracker) const { lpe_->hold_out(tracker); }
    // Trackers of connections: each is a copy that moves past the camera subpath's vertex and the cutouts in between,
    // to the light.
    [[nodiscard]] display::Tracker after(std::uint32_t row, std::int32_t label, const LobeList& lobes) const {
        display::Tracker tracker = trackers_[row];
        scatter(tracker, label, lobes);
        return tracker;
    }
    void pass_through(display::Tracker& tracker, std::int32_t label) const {
        lpe_->move(tracker, events_->straight(label));
    }
    void reach(display::Tracker& tracker, const LightEnd& end) const {
        if (!events_->any()) return;
        scatter(tracker, end.label, end.lobes);
        lpe_->connect(tracker, *end.words, end.word);
    }
    void reach_light(display::Tracker& tracker, std::uint32_t light) const {
        lpe_->move(tracker, events_->terminal(light));
    }
    void add(const display::Tracker& at_light, display::Technique technique, const Arrival& arrival) const;

    // The tracker of a row's subpath. A branch of a split path starts from a copy of it.
    [[nodiscard]] const display::Tracker& tracker(std::uint32_t row) const { return trackers_[row]; }
    void go_back(std::uint32_t row, const display::Tracker& tracker) { trackers_[row] = tracker; }

    [[nodiscard]] const EventTable& events() const { return *events_; }

  private:
    [[nodiscard]] display::Liveness::LiveSet live_set_of_channels(std::uint32_t row, std::int32_t label,
                                                                  std::int32_t material) const;
    /// For subpaths that are not takes_all().
    [[nodiscard]] bool is_followed(std::uint32_t row) const { return !is_dropped(row) && lpe_->live(trackers_[row]); }
    [[nodiscard]] bool is_dropped(std::uint32_t row) const {
        return beauty_alone_ && lpe_->is_held_out(trackers_[row]);
    }
    void scatter(display::Tracker& tracker, std::int32_t label, const LobeList& lobes) const {
        if (!events_->any()) return;
        LobeParts parts;
        lpe_->move(tracker, lobe_parts(*events_, label, lobes, parts));
    }

    const EventTable* events_;
    display::LpeServices* lpe_ = nullptr;
    bool beauty_alone_ = false;
    std::vector<display::Tracker> trackers_;  // by row
};

/// The automata of a render's channels, reversed, for path strings that grow from the light. Not movable: it contains
/// pointers to itself.
class LightLanguage {
  public:
    LightLanguage(const display::LpeSetup& setup, const EventTable& events);
    LightLanguage(const LightLanguage&) = delete;
    LightLanguage& operator=(const LightLanguage&) = delete;
    /// Null where the channels' program is too large to be reversed.
    [[nodiscard]] const lpe::ReversedProgram* reversed() const { return reversed_ ? &*reversed_ : nullptr; }
    /// An empty pool of suffixes.
    [[nodiscard]] display::PathSuffixes pool() const;
    /// Liveness by path suffixes. If beauty is requested, which takes everything, all suffixes are live.
    [[nodiscard]] const display::SuffixLiveness& liveness() const { return liveness_; }
    /// What is live for a suffix that is a light alone. Nothing is live for lights that no channel takes. This holds
    /// even where the liveness of longer suffixes is unknown (bit-parallel channels, programs too large to be
    /// reversed).
    [[nodiscard]] display::SuffixLiveness::LiveSet live_set_of(lpe::EventClass terminal) const;

  private:
    const EventTable* events_;
    bool keeps_paths_, prunes_, has_layers_ = false;
    std::optional<lpe::ReversedProgram> reversed_, reversed_layers_;
    display::SuffixLiveness liveness_;
};

/// The record of light subpaths, row by row.
class LightRecord {
  public:
    /// `language` must outlive the record; null if no channel has an expression.
    LightRecord(const EventTable& events, const LightLanguage* language, std::size_t rows)
        : events_(&events), language_(language) {
        if (language == nullptr) return;
        pool_.emplace(language->pool());
        suffixes_of_row_.resize(rows);
    }
    /// Clears all suffixes.
    void begin(display::LpeServices& lpe) {
        lpe_ = &lpe;
        if (pool_) pool_->clear();
    }
    void leave_light(std::uint32_t row, std::uint32_t light) {
        if (pool_) suffixes_of_row_[row] = lpe_->begin(*pool_, events_->terminal(light));
    }
    /// `key` seeds the choice between lobes if a suffix cannot keep them all.
    void scatter(std::uint32_t row, std::int32_t label, const LobeList& lobes, std::uint64_t key) {
        if (!pool_) return;
        LobeParts parts;
        suffixes_of_row_[row] =
            lpe_->prepend(*pool_, suffixes_of_row_[row], lobe_parts(*events_, label, lobes, parts), key);
    }
    void pass_through(std::uint32_t row, std::int32_t label) {
        if (pool_) suffixes_of_row_[row] = lpe_->prepend(*pool_, suffixes_of_row_[row], events_->straight(label));
    }
    /// Whether a channel can take light of the subpath after further scatterings (Law 4).
    [[nodiscard]] bool is_live(std::uint32_t row) const {
        return takes_all() || (pool_ && language_->liveness().of(*pool_, suffixes_of_row_[row]).goes_on);
    }
    /// What is live after the current vertex of a row's subpath scatters by any lobe of its material.
    [[nodiscard]] display::SuffixLiveness::LiveSet live_set(std::uint32_t row, std::int32_t label,
                                                            std::int32_t material) const {
        if (takes_all()) return {};
        if (!pool_) return {false, false, false};
        return language_->liveness().after(*pool_, suffixes_of_row_[row], events_->scatterings(label, material),
                                           events_->with_density(label, material).size());
    }
    /// Whether a channel can take light of the subpath at its vertex or later, by any lobe of the material there.
    [[nodiscard]] bool is_live(std::uint32_t row, std::int32_t label, std::int32_t material) const {
        return live_set(row, label, material).anything();
    }
    /// Whether a channel can take light of the subpath after a scattering in this medium.
    [[nodiscard]] bool is_live_in_medium(std::uint32_t row, std::int32_t medium) const {
        return is_live(row, events_->medium_label(medium), SurfacePoint::no_material);
    }
    /// Whether a channel can take light of a connection of a camera subpath with `end`, by any lobes of the materials
    /// of both vertices.
    [[nodiscard]] bool is_live_connection(const Record& camera, std::uint32_t row, std::int32_t label,
                                          std::int32_t material, const LightEnd& end,
                                          std::int32_t material_of_end) const {
        return camera.takes_all(row) || !pool_ ||
               language_->liveness().connects(camera.tracker(row), events_->with_density(label, material), *end.words,
                                              end.word, events_->with_density(end.label, material_of_end));
    }
    /// The light end at the current vertex: the suffix behind the vertex. The vertex itself scatters by LightEnd::lobes
    /// when it is connected.
    [[nodiscard]] LightEnd end(std::uint32_t row, std::int32_t label) const {
        LightEnd end;
        end.label = label;
        if (pool_) end.words = &*pool_, end.word = suffixes_of_row_[row];
        return end;
    }
    [[nodiscard]] const EventTable& events() const { return *events_; }

  private:
    [[nodiscard]] bool takes_all() const { return lpe_->wants_beauty() || !events_->prunes(); }

    const EventTable* events_;
    const LightLanguage* language_;
    display::LpeServices* lpe_ = nullptr;
    std::optional<display::PathSuffixes> pool_;
    std::vector<display::PathSuffix> suffixes_of_row_;  // by row
};

inline void Record::add(const display::Tracker& at_light, display::Technique technique, const Arrival& arrival) const {
    if (!lpe_->wants_emitter_samples()) return lpe_->contribute(to_float(arrival.value), technique, at_light);
    lpe_->contribute(
        to_float(arrival.value), technique, at_light,
        {to_float(arrival.emitted), to_float(arrival.unweighted), to_float(arrival.visibility), arrival.sampled_too});
}

inline void Record::arrive(std::uint32_t row, lpe::EventClass terminal, display::Technique technique,
                           const Arrival& arrival) const {
    display::Tracker tracker = trackers_[row];
    lpe_->move(tracker, terminal);
    add(tracker, technique, arrival);
}

template <class Value>
void Record::report_user(std::uint32_t row, std::int32_t label, UserLobe lobe, const Rgb& throughput,
                         Value value) const {
    if (!events_->wants(lobe)) return;
    display::Tracker tracker = trackers_[row];
    lpe_->move(tracker, events_->user(label, lobe));
    lpe_->move(tracker, events_->user_terminal());
    if (lpe_->channels_follow(tracker)) lpe_->contribute_user(to_float(value()), to_float(throughput), tracker);
}

}  // namespace raylex::transport
