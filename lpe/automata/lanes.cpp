#include "lpe/automata/lanes.h"

#include <algorithm>
#include <bit>
#include <map>
#include <unordered_map>
#include <utility>

namespace raylex::lpe {

namespace {

/// One automaton and where its bits stand.
struct Lane {
    const Group* group = nullptr;
    std::vector<std::uint32_t> codes;  // code -> state
    std::unordered_map<std::uint32_t, std::uint32_t> code_of;
    std::uint32_t kind = 0, word = 0, bit = 0;
    std::size_t number = 0;  // among all lanes, kind by kind
};

std::uint32_t kind_of(std::size_t codes) {
    return codes <= 2 ? 0 : codes <= 4 ? 1 : 2;
}

class Packer {
  public:
    Packer(const std::vector<Group>& lanes, const std::vector<Place>& places) : places_(places) {
        std::array<std::uint32_t, ProgramView::lane_kinds> used{};
        for (const Group& group : lanes) {
            Lane lane{&group, lane_codes(group.dfa, places), {}, 0, 0, 0, 0};
            for (std::uint32_t code = 0; code < lane.codes.size(); ++code) {
                lane.code_of.emplace(lane.codes[code], code);
            }
            lane.kind = kind_of(lane.codes.size());
            lane.word = used[lane.kind] / 32;
            lane.bit = used[lane.kind]++ % 32;
            lanes_.push_back(std::move(lane));
        }
        for (std::size_t kind = 0; kind < used.size(); ++kind) {
            tables_.words[kind] = (used[kind] + 31) / 32;
            tables_.lane_count += 32 * tables_.words[kind];
        }
        for (Lane& lane : lanes_) {
            const auto& words = tables_.words;
            lane.number = 32 * ((lane.kind > 0 ? words[0] : 0) + (lane.kind > 1 ? words[1] : 0) + lane.word) + lane.bit;
        }
        can_die_ = std::all_of(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.codes.front() == 0; });
    }

    LaneTables run() {
        write_images();
        const std::vector<std::uint16_t> terminal_of_class = write_terminals();
        write_phase(terminal_of_class);
        return std::move(tables_);
    }

  private:
    /// Words before a kind, when each of its words takes `per_word[kind]`.
    [[nodiscard]] std::size_t offset(std::uint32_t kind, const std::array<std::size_t, 3>& per_word) const {
        std::size_t sum = 0;
        for (std::uint32_t k = 0; k < kind; ++k) { sum += per_word[k] * tables_.words[k]; }
        return sum;
    }

    void set_image(std::vector<std::uint32_t>& image, const Lane& lane, std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t plane = 0; plane <= lane.kind; ++plane) {
            const std::size_t at = offset(lane.kind, images_per_word) +
                                   (from * (lane.kind + 1) + plane) * tables_.words[lane.kind] + lane.word;
            image[at] |= (to >> plane & 1U) << lane.bit;
        }
    }

    void write_images() {
        tables_.image.assign(places_.size(), std::vector<std::uint32_t>(offset(3, images_per_word) + 1, 0));
        for (std::size_t k = 0; k < places_.size(); ++k) {
            if (places_[k] != Place::camera && places_[k] != Place::scattering) { continue; }
            tables_.image[k].back() = can_die_ ? 0 : 1;
            for (const Lane& lane : lanes_) {
                const Dfa& dfa = lane.group->dfa;
                for (std::uint32_t code = 0; code < lane.codes.size(); ++code) {
                    const std::uint32_t from = places_[k] == Place::camera ? dfa.start : lane.codes[code];
                    set_image(tables_.image[k], lane, code,
                              lane.code_of.at(dfa.step(from, static_cast<EventClass>(k))));
                }
            }
        }
    }

    /// Numbers the terminals that differ in what the lanes accept; 0xFFFF where none accepts anything.
    std::vector<std::uint16_t> write_terminals() {
        std::map<std::vector<std::uint32_t>, std::uint16_t> seen;
        std::vector<std::uint16_t> terminal_of_class(places_.size(), no_terminal);
        for (std::size_t k = 0; k < places_.size(); ++k) {
            if (places_[k] != Place::terminal) { continue; }
            std::vector<std::uint32_t> outputs;
            for (const Lane& lane : lanes_) {
                for (const std::uint32_t state : lane.codes) {
                    outputs.push_back(lane.group->dfa.output[lane.group->dfa.step(state, static_cast<EventClass>(k))]);
                }
            }
            if (std::all_of(outputs.begin(), outputs.end(), [](std::uint32_t output) { return output == 0; })) {
                continue;
            }
            const auto [place, fresh] = seen.emplace(outputs, static_cast<std::uint16_t>(seen.size()));
            if (fresh) { add_terminal(outputs); }
            terminal_of_class[k] = place->second;
            tables_.image[k] = ended_[place->second];
        }
        terminals_ = seen.size();
        return terminal_of_class;
    }

    /// Lanes that accept nothing at a terminal go to code 0, so that a path that no lane accepts shows by words that
    /// are all 0. Where code 0 itself accepts it changes places with a code that does not; a lane that accepts in every
    /// code keeps the path alive.
    void add_terminal(const std::vector<std::uint32_t>& outputs) {
        const std::size_t accept = tables_.accept.size(), lists = tables_.lists.size();
        tables_.accept.resize(accept + offset(3, accepts_per_word), 0);
        tables_.lists.resize(lists + std::size_t{lane_code_limit} * tables_.lane_count);
        std::vector<std::uint32_t> image(offset(3, images_per_word) + 1, 0);
        std::size_t first = 0;
        for (const Lane& lane : lanes_) {
            const std::size_t codes = lane.codes.size();
            const auto rejecting =
                static_cast<std::uint32_t>(std::find(outputs.begin() + static_cast<std::ptrdiff_t>(first),
                                                     outputs.begin() + static_cast<std::ptrdiff_t>(first + codes), 0U) -
                                           outputs.begin() - static_cast<std::ptrdiff_t>(first));
            image.back() |= rejecting == codes ? 1U : 0U;
            for (std::uint32_t code = 0; code < codes; ++code) {
                const std::uint32_t output = outputs[first + code];
                const std::uint32_t to = output == 0 ? 0 : code == 0 && rejecting < codes ? rejecting : code;
                set_image(image, lane, code, to);
                if (output != 0) {
                    tables_.accept[accept + offset(lane.kind, accepts_per_word) + to * tables_.words[lane.kind] +
                                   lane.word] |= 1U << lane.bit;
                    tables_.lists[lists + lane_code_limit * lane.number + to] = lane.group->lists[output];
                }
            }
            first += codes;
        }
        ended_.push_back(std::move(image));
    }

    void write_phase(const std::vector<std::uint16_t>& terminal_of_class) {
        constexpr std::uint32_t start = 1, on_the_way = 2;
        Dfa& dfa = tables_.phase.dfa;
        dfa.start = start;
        dfa.columns = 3 + terminals_;  // nothing, camera, scattering, terminals
        dfa.output.assign(LaneTables::first_ended + terminals_, 0);
        dfa.next.assign(dfa.output.size() * dfa.columns, 0);
        dfa.next[start * dfa.columns + 1] = on_the_way;
        dfa.next[on_the_way * dfa.columns + 2] = on_the_way;
        for (std::uint32_t t = 0; t < terminals_; ++t) {
            dfa.next[on_the_way * dfa.columns + 3 + t] = LaneTables::first_ended + t;
        }
        for (std::size_t k = 0; k < places_.size(); ++k) {
            const bool ends = terminal_of_class[k] != no_terminal;
            dfa.column_of_class.push_back(static_cast<std::uint16_t>(places_[k] == Place::camera       ? 1
                                                                     : places_[k] == Place::scattering ? 2
                                                                     : ends ? 3 + terminal_of_class[k]
                                                                            : 0));
        }
    }

    static constexpr std::uint16_t no_terminal = 0xFFFF;
    static constexpr std::array<std::size_t, 3> images_per_word{2, 8, 24}, accepts_per_word{2, 4, 8};
    const std::vector<Place>& places_;
    std::vector<Lane> lanes_;
    bool can_die_ = false;                           // all words 0 underway means that no lane can accept any more
    std::vector<std::vector<std::uint32_t>> ended_;  // [terminal] image
    std::size_t terminals_ = 0;
    LaneTables tables_;
};

}  // namespace

LaneTables pack_lanes(const std::vector<Group>& lanes, const std::vector<Place>& places) {
    return Packer(lanes, places).run();
}

std::size_t lane_word_count(const std::vector<Group>& lanes, const std::vector<Place>& places) {
    std::array<std::size_t, ProgramView::lane_kinds> lanes_of{};
    for (const Group& lane : lanes) { ++lanes_of[kind_of(lane_codes(lane.dfa, places).size())]; }
    std::size_t words = 0;
    for (std::size_t kind = 0; kind < lanes_of.size(); ++kind) { words += (kind + 1) * ((lanes_of[kind] + 31) / 32); }
    return words;
}

}  // namespace raylex::lpe
