#include "experiments/cli/lpe/picture.h"

#include <algorithm>
#include <map>

#include "experiments/job/text/json.h"
#include "experiments/program/columns.h"
#include "experiments/program/console.h"
#include "lpe/match.h"

namespace raylex::experiments {
namespace {

constexpr std::size_t matrix_most = 16;  // maximum number of channels in the matrix
constexpr std::size_t names_most = 8;    // maximum number of names in one line
constexpr std::size_t lines_most = 26;   // maximum number of lines in a section

std::string with_events(const lpe::Witness& witness) {
    return witness.sentence + " (" + witness.text + ")";
}

std::string names_text(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t k = 0; k < std::min(names.size(), names_most); ++k)
        text += (k == 0 ? "'" : ", '") + names[k] + "'";
    return names.size() <= names_most ? text : text + " and " + std::to_string(names.size() - names_most) + " more";
}

const std::string& name_of(const CheckPicture& picture, std::size_t channel) {
    return picture.layers.sources[channel].name;
}

void print_head(const CheckPicture& picture) {
    if (picture.files.empty()) return;
    std::string files;
    for (const std::string& file : picture.files) files += (files.empty() ? "" : ", ") + file;
    print_line(files + ": " + std::to_string(picture.channels) + (picture.channels == 1 ? " channel" : " channels") +
               " with expressions, " + std::to_string(picture.layers.sources.size()) + " of them layers");
    std::map<std::string, std::vector<std::string>> aside;
    for (const auto& [name, why] : picture.layers.no_layers) aside[why].push_back(name);
    for (const auto& [why, names] : aside) print_line("  not layers (" + why + "): " + names_text(names));
    if (!picture.words.alphabet && !picture.words.volume)
        print_line("  paths that scatter in media are excluded; --volume includes them");
}

/// Returns the k-th letter: "a" to "z", then "aa", ...
std::string letter_of(std::size_t k) {
    std::string text(1, static_cast<char>('a' + k % 26));
    return k < 26 ? text : letter_of(k / 26 - 1) + text;
}

/// Pairs of channels grouped by the path they share, the shortest path first.
struct SharedBy {
    const lpe::Witness* witness = nullptr;
    std::vector<const lpe::SharedPath*> pairs;
};

std::vector<SharedBy> by_path(const lpe::Overview& overview) {
    std::map<std::pair<std::size_t, std::string>, SharedBy> found;
    for (const lpe::SharedPath& each : overview.overlaps) {
        SharedBy& shared = found[{each.witness.events.size(), each.witness.text}];
        shared.witness = &each.witness;
        shared.pairs.push_back(&each);
    }
    std::vector<SharedBy> list;
    for (auto& [key, shared] : found) list.push_back(std::move(shared));
    return list;
}

std::vector<std::size_t> channels_of(const std::vector<const lpe::SharedPath*>& pairs) {
    std::vector<std::size_t> channels;
    for (const lpe::SharedPath* each : pairs) channels.insert(channels.end(), {each->first, each->second});
    std::sort(channels.begin(), channels.end());
    channels.erase(std::unique(channels.begin(), channels.end()), channels.end());
    return channels;
}

/// Prints a matrix with a row and a column for each channel that overlaps another. A cell holds the letter of the
/// shortest path that both channels count.
void print_matrix(const CheckPicture& picture, const std::vector<SharedBy>& shared,
                  const std::vector<std::size_t>& involved) {
    std::map<std::pair<std::size_t, std::size_t>, std::string> cells;
    std::size_t cell_width = std::to_string(involved.size()).size(), name_width = 0;
    for (std::size_t k = 0; k < shared.size(); ++k)
        for (const lpe::SharedPath* pair : shared[k].pairs) {
            cells[{pair->first, pair->second}] = cells[{pair->second, pair->first}] = letter_of(k);
            cell_width = std::max(cell_width, letter_of(k).size());
        }
    for (const std::size_t channel : involved) name_width = std::max(name_width, name_of(picture, channel).size());
    const std::size_t number_width = std::to_string(involved.size()).size();
    std::string head = padded("", number_width + name_width + 5);
    for (std::size_t k = 0; k < involved.size(); ++k) head += padded(std::to_string(k + 1), cell_width + 1);
    const auto without_trail = [](const std::string& line) { return line.substr(0, line.find_last_not_of(' ') + 1); };
    print_line(without_trail(head));
    for (std::size_t row = 0; row < involved.size(); ++row) {
        std::string line = "  " + padded(std::to_string(row + 1), number_width + 1) +
                           padded(name_of(picture, involved[row]), name_width + 2);
        for (const std::size_t column : involved) {
            const auto cell = cells.find({involved[row], column});
            line += padded(column == involved[row] ? "\\" : cell == cells.end() ? "." : cell->second, cell_width + 1);
        }
        print_line(without_trail(line));
    }
}

void print_overlaps(const CheckPicture& picture) {
    const lpe::Overview& overview = picture.overview;
    if (overview.overlaps.empty()) return;
    const std::vector<SharedBy> shared = by_path(overview);
    std::vector<const lpe::SharedPath*> all;
    for (const lpe::SharedPath& each : overview.overlaps) all.push_back(&each);
    const std::vector<std::size_t> involved = channels_of(all);
    print_line("");
    print_line(
        (overview.overlaps.size() == 1 ? "1 pair counts" : std::to_string(overview.overlaps.size()) + " pairs count") +
        std::string(" the same light; the shortest path of each:"));
    const bool matrix = involved.size() > 2 && involved.size() <= matrix_most;
    if (matrix) print_matrix(picture, shared, involved);
    for (std::size_t k = 0; k < std::min(shared.size(), lines_most); ++k) {
        std::vector<std::string> names;
        for (const std::size_t channel : channels_of(shared[k].pairs)) names.push_back(name_of(picture, channel));
        const std::string pairs =
            shared[k].pairs.size() == 1 ? "" : ", " + std::to_string(shared[k].pairs.size()) + " pairs";
        print_line("  " + (matrix ? padded(letter_of(k), 3) : "") + with_events(*shared[k].witness) +
                   (matrix ? "" : ": " + names_text(names) + pairs));
    }
    if (shared.size() > lines_most)
        print_line("  and " + std::to_string(shared.size() - lines_most) + " more paths (--json has all of them)");
    if (overview.pairs_left > 0)
        print_line("  " + std::to_string(overview.pairs_left) + " more pairs were not compared");
}

bool same_but_end(const lpe::Witness& a, const lpe::Witness& b) {
    return a.text.substr(0, a.text.rfind(' ')) == b.text.substr(0, b.text.rfind(' '));
}

void print_holes(const CheckPicture& picture) {
    const lpe::Overview& overview = picture.overview;
    if (!overview.holes_unknown.empty()) print_note("gaps were not searched for: " + overview.holes_unknown);
    if (overview.holes.empty()) return;
    print_line("");
    print_line("Paths that no channel counts (shortest of each kind):");
    std::size_t width = 0;
    for (const lpe::Hole& hole : overview.holes) width = std::max(width, hole.kind.size());
    for (const lpe::Hole& hole : overview.holes) {
        std::string ends;
        std::vector<std::string> others;
        for (const lpe::Witness& other : hole.others) {
            if (same_but_end(hole.witness, other))
                ends += (ends.empty() ? "" : ", ") + lpe::to_sentence(other.events.back());
            else others.push_back(with_events(other));
        }
        print_line("  " + padded(hole.kind, width + 2) + with_events(hole.witness) +
                   (ends.empty() ? "" : "; likewise to: " + ends));
        for (const std::string& other : others) print_line("  " + padded("", width + 2) + other);
    }
    const bool all_in_media = std::all_of(overview.holes.begin(), overview.holes.end(), [](const lpe::Hole& hole) {
        return hole.witness.text.find(" V,") != std::string::npos;
    });
    if (all_in_media) print_line("  all of these scatter in media; --no-volume excludes such paths");
    if (!picture.rest.empty()) print_line("  all of them as a channel: rest=\"" + picture.rest + "\"");
    if (!picture.rest_note.empty()) print_line("  " + picture.rest_note);
}

void print_outside(const CheckPicture& picture) {
    const auto& outside = picture.overview.outside;
    if (!outside.empty()) {
        print_line("");
        print_line("Paths that a channel counts, but that are not part of the whole (shortest of each):");
    }
    for (std::size_t k = 0; k < std::min(outside.size(), lines_most); ++k)
        print_line("  '" + name_of(picture, outside[k].channel) + "': " + with_events(outside[k].witness));
    if (outside.size() > lines_most)
        print_line("  and " + std::to_string(outside.size() - lines_most) + " more channels");
}

std::vector<std::string> names_of(const CheckPicture& picture, const std::vector<std::size_t>& channels) {
    std::vector<std::string> names;
    for (const std::size_t channel : channels) names.push_back(name_of(picture, channel));
    return names;
}

void print_sorting(const CheckPicture& picture) {
    const lpe::Sorting& sorting = picture.sorting;
    if (sorting.partitions.empty()) return;
    for (const auto& partition : sorting.partitions)
        print_line("  a partition by " + std::string(partition.size() == 1 ? "itself: " : "themselves: ") +
                   names_text(names_of(picture, partition)));
    if (!sorting.left.empty())
        print_line("  in none: " + names_text(names_of(picture, sorting.left)) + "; the following is about " +
                   (sorting.left.size() == 1 ? "it" : "them") + " alone");
}

Json path_json(const lpe::Witness& witness) {
    return {{"events", witness.text}, {"words", witness.sentence}};
}

Json overview_json(const CheckPicture& picture) {
    Json holes = Json::array(), overlaps = Json::array(), outside = Json::array(), empty = Json::array();
    for (const lpe::Hole& hole : picture.overview.holes) {
        Json paths = Json::array({path_json(hole.witness)});
        for (const lpe::Witness& other : hole.others) paths.push_back(path_json(other));
        holes.push_back({{"kind", hole.kind}, {"paths", std::move(paths)}});
    }
    for (const lpe::SharedPath& each : picture.overview.overlaps)
        overlaps.push_back({{"channels", {name_of(picture, each.first), name_of(picture, each.second)}},
                            {"path", path_json(each.witness)}});
    for (const lpe::OutsidePath& each : picture.overview.outside)
        outside.push_back({{"channel", name_of(picture, each.channel)}, {"path", path_json(each.witness)}});
    for (const std::size_t each : picture.overview.empty) empty.push_back(name_of(picture, each));
    return {{"holes", std::move(holes)},
            {"overlaps", std::move(overlaps)},
            {"outside", std::move(outside)},
            {"empty", std::move(empty)},
            {"pairs_not_compared", picture.overview.pairs_left}};
}

}  // namespace

void print_picture(const CheckPicture& picture) {
    for (const std::string& warning : picture.warnings) print_warning(warning);
    for (const std::size_t channel : picture.overview.empty)
        print_warning("channel '" + name_of(picture, channel) + "' counts no path");
    print_head(picture);
    print_sorting(picture);
    print_overlaps(picture);
    print_holes(picture);
    print_outside(picture);
    if (!picture.holds) print_line("");
    print_line((picture.partition.empty() ? "" : "partition '" + picture.partition + "': ") + picture.summary);
    if (!picture.holds) print_line(picture.witness.text);
    if (picture.alone) print_line("");
}

std::string pictures_as_json(const std::vector<CheckPicture>& pictures) {
    Json list = Json::array();
    for (const CheckPicture& picture : pictures) {
        Json layers = Json::array(), others = Json::array();
        for (const lpe::ChannelSource& source : picture.layers.sources)
            layers.push_back({{"name", source.name},
                              {"lpe", source.expression},
                              {"dialect", source.dialect == lpe::Dialect::osl ? "osl" : "renderman"},
                              {"file", source.origin_line > 0 ? source.origin : std::string()},
                              {"line", source.origin_line}});
        for (const auto& [name, why] : picture.layers.no_layers) others.push_back({{"name", name}, {"why", why}});
        Json one{{"verdict", picture.result}, {"holds", picture.holds}, {"summary", picture.summary}};
        if (!picture.partition.empty()) one["partition"] = picture.partition;
        one["files"] = picture.files;
        if (!picture.holds) one["path"] = path_json(picture.witness);
        if (picture.layers.whole) one["of"] = picture.layers.whole->expression;
        one["volume"] = picture.words.volume;
        one["layers"] = std::move(layers);
        one["no_layers"] = std::move(others);
        one.update(overview_json(picture));
        for (const auto& partition : picture.sorting.partitions)
            one["partitions"].push_back(names_of(picture, partition));
        if (!picture.rest.empty()) one["rest"] = picture.rest;
        one["warnings"] = picture.warnings;
        list.push_back(std::move(one));
    }
    return json_text(list, 2);
}

}  // namespace raylex::experiments
