// The record of paths: the one place that calls the LPE services.
//
// A record keeps, row by row, where each camera subpath stands in the language. Walks and integrators report events to
// it (scattered by these lobes, arrived at that light) and read two answers: whether the path is live, and whether a
// connection is live. The record and the services alone deal with channels, their liveness (Law 4), the shares
// of lobes (Law 5), prefixes and holdouts.
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

/// The far end of a connection: a vertex of a light subpath, as the camera's side meets it.
struct LightEnd {
    std::int32_t label = 0;
    LobeList lobes;  ///< of the scattering there towards the camera's side
    const display::PathSuffixes* words = nullptr;
    display::PathSuffix word;  ///< the path suffix from the vertex to the light; valid until the next batch
};

/// Light that a path brings to the camera.
struct Arrival {
    Rgb value{};                     ///< the contribution to beauty
    Rgb emitted{};                   ///< radiance that leaves the emitter towards the path
    Rgb unweighted{};                ///< `value` with nothing in the way, and without the MIS weight
    Real visibility = 1;             ///< fraction that arrives
    bool found_by_sampling = false;  ///< light sampling finds the same emitter there too
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
    /// `rows` is the number of camera subpaths; 0 for records of splats.
    explicit Record(const EventTable& events, std::size_t rows = 0) : events_(&events), trackers_(rows) {}

    /// Rows [0, count) stand at the camera.
    void begin(display::LpeServices& lpe, std::size_t count) {
        lpe_ = &lpe;
        for (std::size_t row = 0; row < count; ++row) trackers_[row] = lpe.begin(static_cast<int>(row));
    }
    /// Without rows: report by these services.
    void begin(display::LpeServices& lpe) { lpe_ = &lpe; }

    // What happens to the camera subpath of a row. `label` is an object's, or EventTable::medium_label().
    void scatter(std::uint32_t row, std::int32_t label, const LobeList& lobes) {
        scatter(trackers_[row], label, lobes);
    }
    void pass_through(std::uint32_t row, std::int32_t label) { pass_through(trackers_[row], label); }
    /// Its first hit is a holdout.
    void hold_out(std::uint32_t row) { lpe_->hold_out(trackers_[row]); }
    /// It has arrived at an emitter whose event is `terminal`.
    void arrive(std::uint32_t row, lpe::EventClass terminal, display::Technique technique,
                const Arrival& arrival) const;
    /// Its throughput is NaN or infinite: counted and logged (Law 6).
    void reject(std::uint32_t row, const Rgb& throughput) const {
        lpe_->contribute(to_float(throughput), {}, trackers_[row]);
    }
    /// Reports a user event of the surface, if a channel takes it. `throughput`: up to the surface. `value()` is called
    /// only then.
    template <class Value>
    void say(std::uint32_t row, std::int32_t label, UserLobe lobe, const Rgb& throughput, Value value) const;

    /// Whether the subpath can still find light that counts.
    [[nodiscard]] bool is_live(std::uint32_t row) const {
        return takes_all(row) || (lpe_->live(trackers_[row]) && events_->liveness().of(trackers_[row]).anything);
    }
    /// What channels can still take behind the vertex, whichever lobe of its material scatters.
    [[nodiscard]] display::Liveness::LiveSet live_set(std::uint32_t row, std::int32_t label,
                                                      std::int32_t material) const {
        return takes_all(row) ? display::Liveness::LiveSet() : live_set_of_channels(row, label, material);
    }
    /// Whether the subpath can find light that counts at its vertex or behind it, by any lobe of the material there.
    [[nodiscard]] bool is_live(std::uint32_t row, std::int32_t label, std::int32_t material) const {
        return live_set(row, label, material).anything;
    }
    /// Whether the subpath can find light that counts behind its vertex if this lobe scatters it there.
    [[nodiscard]] bool is_live_lobe(std::uint32_t row, std::int32_t label, LobeId lobe) const {
        const lpe::EventClass event = events_->scatter(label, lobe);
        return lpe_->live(trackers_[row]) && events_->liveness().after(trackers_[row], {&event, 1}).anything;
    }
    /// Whether the subpath can find light that counts behind a collision with a particle of this medium.
    [[nodiscard]] bool is_live_in_medium(std::uint32_t row, std::int32_t medium) const;
    /// True if beauty takes the whole path, or if pruning is off. Then is_live() is true as well.
    [[nodiscard]] bool takes_all(std::uint32_t row) const {
        return lpe_->takes_all(trackers_[row]) || !events_->prunes();
    }
    /// Whether a channel other than beauty takes some of it.
    [[nodiscard]] bool channels_follow(std::uint32_t row) const { return lpe_->channels_follow(trackers_[row]); }
    /// Whether blocked light must be reported too.
    [[nodiscard]] bool wants_blocked_light() const { return lpe_->wants_emitter_samples(); }

    enum class Liveness : std::uint8_t {
        dead,              ///< no channel takes the connection
        if_visible,        ///< some channel takes what arrives: trace a shadow ray
        if_visible_or_not  ///< channels take it whatever is in the way: report it without a ray
    };
    /// Whether a channel takes a connection of the subpath of a row, scattered at its vertex by these lobes towards a
    /// light, or towards `end`. For rows that beauty does not take whole. `cutouts`: there may be some in between,
    /// which leave events of their own.
    [[nodiscard]] Liveness liveness_of_connection(std::uint32_t row, std::int32_t label, const LobeList& lobes,
                                                  std::uint32_t light, const LightEnd* end, bool cutouts) const;
    /// Whether a channel takes the connection of `end` to the camera.
    [[nodiscard]] bool is_live_splat(std::uint32_t row, const LightEnd& end) const;

    void hold_out(display::Tracker& tracker) const { lpe_->hold_out(tracker); }
    // Connections move their own tracker: past the camera subpath's vertex, past cutouts in between, to the light.
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
        lpe_->join(tracker, *end.words, end.word);
    }
    void reach_light(display::Tracker& tracker, std::uint32_t light) const {
        lpe_->move(tracker, events_->terminal(light));
    }
    void add(const display::Tracker& at_light, display::Technique technique, const Arrival& arrival) const;

    // Where the subpath of a row stands in the language. A branch of a split path begins there again.
    [[nodiscard]] const display::Tracker& tracker(std::uint32_t row) const { return trackers_[row]; }
    void go_back(std::uint32_t row, const display::Tracker& tracker) { trackers_[row] = tracker; }

    [[nodiscard]] const EventTable& events() const { return *events_; }

  private:
    [[nodiscard]] display::Liveness::LiveSet live_set_of_channels(std::uint32_t row, std::int32_t label,
                                                                  std::int32_t material) const;
    void scatter(display::Tracker& tracker, std::int32_t label, const LobeList& lobes) const {
        if (!events_->any()) return;
        LobeParts parts;
        lpe_->move(tracker, lobe_parts(*events_, label, lobes, parts));
    }

    const EventTable* events_;
    display::LpeServices* lpe_ = nullptr;
    std::vector<display::Tracker> trackers_;  // by row
};

/// The language of a render's channels, read from the lights. Cannot be moved: it points at itself.
class LightLanguage {
  public:
    LightLanguage(const display::LpeSetup& setup, const EventTable& events);
    LightLanguage(const LightLanguage&) = delete;
    LightLanguage& operator=(const LightLanguage&) = delete;
    /// Null where the channels' program is too large to be reversed.
    [[nodiscard]] const lpe::ReversedProgram* reversed() const { return reversed_ ? &*reversed_ : nullptr; }
    /// Whether a path atlas needs the events as well.
    [[nodiscard]] bool keeps_paths() const { return keeps_paths_; }
    /// Nothing is known if beauty is requested, which takes all.
    [[nodiscard]] const display::SuffixLiveness& liveness() const { return liveness_; }
    /// For a light's suffix: liveness(), but nothing for lights that no channel takes. These are known even where
    /// suffixes are not (bit-parallel channels, programs too large to be reversed).
    [[nodiscard]] display::SuffixLiveness::LiveSet live_set_of(lpe::EventClass terminal) const;

  private:
    const EventTable* events_;
    bool keeps_paths_, prunes_;
    std::optional<lpe::ReversedProgram> reversed_;
    display::SuffixLiveness liveness_;
};

/// The record of light subpaths, row by row.
class LightRecord {
  public:
    /// `language` must outlive the record; null if no channel has an expression.
    LightRecord(const EventTable& events, const LightLanguage* language, std::size_t rows)
        : events_(&events), language_(language) {
        if (language == nullptr) return;
        words_.emplace(language->reversed(), language->keeps_paths());
        word_.resize(rows);
    }
    /// Clears all suffixes.
    void begin(display::LpeServices& lpe) {
        lpe_ = &lpe;
        if (words_) words_->clear();
    }
    void leave_light(std::uint32_t row, std::uint32_t light) {
        if (words_) word_[row] = lpe_->begin(*words_, events_->terminal(light));
    }
    /// `key` seeds the choice between lobes if a suffix cannot keep them all.
    void scatter(std::uint32_t row, std::int32_t label, const LobeList& lobes, std::uint64_t key) {
        if (!words_) return;
        LobeParts parts;
        word_[row] = lpe_->prepend(*words_, word_[row], lobe_parts(*events_, label, lobes, parts), key);
    }
    void pass_through(std::uint32_t row, std::int32_t label) {
        if (words_) word_[row] = lpe_->prepend(*words_, word_[row], events_->straight(label));
    }
    /// Whether further scatterings of the subpath can count (Law 4).
    [[nodiscard]] bool is_live(std::uint32_t row) const {
        return takes_all() || (words_ && language_->liveness().of(*words_, word_[row]).goes_on);
    }
    /// What is live once its current vertex scatters by any lobe of the material there.
    [[nodiscard]] display::SuffixLiveness::LiveSet live_set(std::uint32_t row, std::int32_t label,
                                                            std::int32_t material) const {
        if (takes_all()) return {};
        if (!words_) return {false, false, false};
        return language_->liveness().after(*words_, word_[row], events_->scatterings(label, material),
                                           events_->with_density(label, material).size());
    }
    /// Whether the subpath can count at its vertex or after it, by any lobe of the material there.
    [[nodiscard]] bool is_live(std::uint32_t row, std::int32_t label, std::int32_t material) const {
        return live_set(row, label, material).anything();
    }
    /// Whether the subpath can count after a collision with a particle of this medium.
    [[nodiscard]] bool is_live_in_medium(std::uint32_t row, std::int32_t medium) const {
        return is_live(row, events_->medium_label(medium), SurfacePoint::no_material);
    }
    /// Whether a connection of a camera subpath with `end` can count, by any lobes of the materials of both vertices.
    [[nodiscard]] bool is_live_connection(const Record& camera, std::uint32_t row, std::int32_t label,
                                          std::int32_t material, const LightEnd& end,
                                          std::int32_t material_of_end) const {
        return camera.takes_all(row) || !words_ ||
               language_->liveness().joins(camera.tracker(row), events_->with_density(label, material), *end.words,
                                           end.word, events_->with_density(end.label, material_of_end));
    }
    /// The suffix behind the current vertex. The vertex itself scatters by LightEnd::lobes when it is connected.
    [[nodiscard]] LightEnd end(std::uint32_t row, std::int32_t label) const {
        LightEnd end;
        end.label = label;
        if (words_) end.words = &*words_, end.word = word_[row];
        return end;
    }
    [[nodiscard]] const EventTable& events() const { return *events_; }

  private:
    [[nodiscard]] bool takes_all() const { return lpe_->wants_beauty() || !events_->prunes(); }

    const EventTable* events_;
    const LightLanguage* language_;
    display::LpeServices* lpe_ = nullptr;
    std::optional<display::PathSuffixes> words_;
    std::vector<display::PathSuffix> word_;  // by row
};

inline void Record::add(const display::Tracker& at_light, display::Technique technique, const Arrival& arrival) const {
    if (!lpe_->wants_emitter_samples()) return lpe_->contribute(to_float(arrival.value), technique, at_light);
    lpe_->contribute(to_float(arrival.value), technique, at_light,
                     {to_float(arrival.emitted), to_float(arrival.unweighted), to_float(arrival.visibility),
                      arrival.found_by_sampling});
}

inline void Record::arrive(std::uint32_t row, lpe::EventClass terminal, display::Technique technique,
                           const Arrival& arrival) const {
    display::Tracker tracker = trackers_[row];
    lpe_->move(tracker, terminal);
    add(tracker, technique, arrival);
}

template <class Value>
void Record::say(std::uint32_t row, std::int32_t label, UserLobe lobe, const Rgb& throughput, Value value) const {
    if (!events_->wants(lobe)) return;
    display::Tracker tracker = trackers_[row];
    lpe_->move(tracker, events_->user(label, lobe));
    lpe_->move(tracker, events_->user_terminal());
    if (lpe_->channels_follow(tracker)) lpe_->contribute_user(to_float(value()), to_float(throughput), tracker);
}

}  // namespace raylex::transport
