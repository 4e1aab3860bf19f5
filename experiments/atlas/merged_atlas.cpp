#include "experiments/atlas/merged_atlas.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "experiments/job/text/toml_text.h"
#include "lpe/match.h"

namespace raylex::experiments {
namespace {

using display::PathAtlas;
using display::PathStringTable;

std::string attribute(const display::AtlasFile& file, const char* name) {
    const auto& attributes = file.description().attributes;
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::string() : found->second;
}

std::uint64_t number_attribute(const display::AtlasFile& file, const char* name) {
    return std::strtoull(attribute(file, name).c_str(), nullptr, 10);
}

/// A range of samples [first, end) of a seed.
struct Sampled {
    std::uint64_t seed = 0, first = 0, end = 0;
    auto operator<=>(const Sampled&) const = default;
};
constexpr std::uint64_t all_samples = ~std::uint64_t{0};  // the end of the range if the atlas is not of a shard

/// Header attribute of an atlas that does not have all samples of its seeds: "7:0-15,7:32-47".
constexpr const char* sampled_attribute = "raylex/sampled";

std::string to_text(const Sampled& range) {
    return std::to_string(range.seed) + ":" + std::to_string(range.first) + "-" + std::to_string(range.end - 1);
}

std::vector<Sampled> sampled(const display::AtlasFile& file) {
    std::vector<Sampled> list;
    const std::string shards = attribute(file, sampled_attribute);
    std::istringstream text(shards.empty() ? attribute(file, "raylex/seed") : shards);
    char mark = 0;
    for (Sampled each; text >> each.seed; text >> mark) {
        each.end = all_samples;
        if (!shards.empty()) text >> mark >> each.first >> mark >> each.end, ++each.end;
        list.push_back(each);
    }
    return list;
}

/// Returns a text of the samples that two overlapping ranges share.
std::string text_of(const Sampled& a, const Sampled& b) {
    const std::uint64_t end = std::min(a.end, b.end);
    const std::string seed = "seed " + std::to_string(a.seed);
    if (end == all_samples) return seed;
    return seed + ", samples " + std::to_string(std::max(a.first, b.first)) + " to " + std::to_string(end - 1);
}

/// Returns the job without settings in which renders of one image may differ: number of samples, seed, threads, further
/// outputs and file names.
std::string job_of_image(const display::AtlasFile& file) {
    const std::string text = attribute(file, "raylex/job");
    auto job = parse_toml(text, file.path());
    if (!job) return text;
    for (const char* name : {"output", "exr", "deep", "driver", "atlas", "channels", "channel", "partition", "layer"})
        job->erase(name);
    if (toml::table* render = (*job)["render"].as_table(); render != nullptr)
        for (const char* name : {"seed", "spp", "threads", "time"}) render->erase(name);
    std::ostringstream rest;
    rest << *job;
    return rest.str();
}

/// Returns a text of the first difference that makes two atlases belong to different images; empty if there is none.
std::string first_difference(const display::AtlasFile& a, const display::AtlasFile& b) {
    const auto size = [](const display::AtlasFile& file) {
        return std::to_string(file.width()) + " x " + std::to_string(file.height()) + " pixels";
    };
    if (size(a) != size(b)) return "have " + size(a) + " and " + size(b);
    const auto rules = [](const display::AtlasFile& file) {
        return "'" + to_string(file.table().rules) + "' and length " + std::to_string(file.table().rules.length);
    };
    if (rules(a) != rules(b)) return "distinguish path strings by " + rules(a) + " and by " + rules(b);
    if (attribute(a, "atlas/scene") != attribute(b, "atlas/scene")) return "belong to scenes with different events";
    if (a.description().chromaticities != b.description().chromaticities) return "have different chromaticities";
    if (job_of_image(a) != job_of_image(b))
        return "belong to jobs that differ in more than samples, seed, threads and outputs";
    for (const char* name : {"raylex/scene", "raylex/integrator", "raylex/filter"})
        if (attribute(a, name) != attribute(b, name))
            return "have '" + attribute(a, name) + "' and '" + attribute(b, name) + "' as " + name;
    return {};
}

Status check_pair(const display::AtlasFile& a, const display::AtlasFile& b) {
    if (const std::string what = first_difference(a, b); !what.empty())
        return error_at({b.path(), 0, 0}, "cannot be merged with " + a.path() + ": the two " + what +
                                              "; expected atlases of one scene with equal settings");
    for (const Sampled& of_a : sampled(a))
        for (const Sampled& of_b : sampled(b))
            if (of_a.seed == of_b.seed && of_a.first < of_b.end && of_b.first < of_a.end)
                return error_at({b.path(), 0, 0},
                                "cannot be merged with " + a.path() + ": both have " + text_of(of_a, of_b) +
                                    ", so the same samples would count twice",
                                "render one of them with another --seed, or as another --shard");
    return success();
}

double mean_luminance(const display::PathStringSample& sample) {
    return (sample.rgb[0] + sample.rgb[1] + sample.rgb[2]) / 3;
}

/// Returns the letters of a word, and how its light was found.
std::vector<PathStringTable::Letter> whole_path_string(const PathStringTable& table, std::uint32_t word) {
    std::vector<PathStringTable::Letter> letters = table.words[word];
    if (!table.techniques.empty()) letters.push_back(display::PathAlphabet::letter_of(table.techniques[word]));
    return letters;
}

/// Sums the terms in an order that depends only on their values, so that the order of files does not matter.
double sum_of(std::vector<double>& terms) {
    std::sort(terms.begin(), terms.end());
    double sum = 0;
    for (const double term : terms) sum += term;
    terms.clear();
    return sum;
}

}  // namespace

display::ImageDescription of_samples(display::ImageDescription description, std::uint64_t first, std::uint64_t end) {
    std::map<std::string, std::string>& attributes = description.attributes;
    attributes["raylex/samples_per_pixel"] = std::to_string(end - first);
    attributes[sampled_attribute] =
        to_text({std::strtoull(attributes["raylex/seed"].c_str(), nullptr, 10), first, end});
    return description;
}

Result<std::unique_ptr<MergedAtlas>> MergedAtlas::open(const std::vector<std::string>& paths) {
    std::unique_ptr<MergedAtlas> merged(new MergedAtlas());
    for (const std::string& path : paths) {
        auto file = display::AtlasFile::open(path);
        if (!file) return file.error();
        if ((*file)->table().negative == display::SignedLight::weights)
            return error_at({path, 0, 0},
                            "its pixel filter has negative lobes, and atlases do not store the sum of filter weights, "
                            "so it cannot be merged; expected box, triangle, gaussian or blackman-harris");
        for (const auto& other : merged->files_)
            if (Status good = check_pair(*other, **file); !good) return good.error();
        merged->files_.push_back(*std::move(file));
    }
    if (Status joined = merged->join_tables(); !joined) return joined.error();
    merged->rows_.resize(merged->files_.size());
    return merged;
}

Status MergedAtlas::join_tables() {
    std::map<std::string, std::pair<PathStringTable::Letter, lpe::Event>> letter_of;
    std::map<std::vector<PathStringTable::Letter>, std::uint32_t> words;
    table_.rules = files_.front()->table().rules;
    for (const auto& file : files_) {
        const PathStringTable& table = file->table();
        for (std::size_t i = 0; i < table.events.size(); ++i) {
            const auto [place, fresh] =
                letter_of.try_emplace(lpe::to_text(table.events[i]), std::pair(table.letters[i], table.events[i]));
            if (!fresh && place->second.first != table.letters[i])
                return error_at({file->path(), 0, 0}, "cannot be merged with " + files_.front()->path() +
                                                          ": their letters represent different events");
        }
        for (std::uint32_t word = 0; word < table.words.size(); ++word)
            words.try_emplace(whole_path_string(table, word), 0);
        table_.negative = std::max(table_.negative, table.negative);
        table_.dropped_straight = table_.dropped_straight || table.dropped_straight;
        table_.merged += table.merged;
    }
    for (const auto& [text, letter] : letter_of) {
        table_.letters.push_back(letter.first);
        table_.events.push_back(letter.second);
    }
    for (auto& [word, number] : words) {
        number = static_cast<std::uint32_t>(table_.words.size());
        table_.words.push_back(word);
        if (!table_.rules.techniques) continue;
        table_.techniques.push_back(display::PathAlphabet::technique_of(word.back()));
        table_.words.back().pop_back();
    }
    for (const auto& file : files_) {
        std::vector<std::uint32_t>& number_of = number_of_.emplace_back();
        for (std::uint32_t word = 0; word < file->table().words.size(); ++word)
            number_of.push_back(words.at(whole_path_string(file->table(), word)));
    }
    return success();
}

Status MergedAtlas::row(int y, display::AtlasRow& row) {
    for (std::size_t i = 0; i < files_.size(); ++i)
        if (Status read = files_[i]->row(y, rows_[i]); !read) return read;
    row.begin.assign(1, 0);
    row.samples.clear();
    const auto columns = static_cast<std::size_t>(width());
    row.rgba.resize(columns);
    row.counts.resize(columns);
    for (std::size_t x = 0; x < columns; ++x) merge_pixel(x, row);
    return success();
}

void MergedAtlas::merge_pixel(std::size_t x, display::AtlasRow& row) {
    std::vector<double> samples(rows_.size(), 0), terms;
    double all = 0;
    parts_.clear();
    for (std::size_t f = 0; f < rows_.size(); ++f) {
        for (const float count : rows_[f].counts[x]) samples[f] += static_cast<double>(count);
        all += samples[f];  // integers: exact in any order
        for (std::size_t i = rows_[f].begin[x]; i < rows_[f].begin[x + 1]; ++i)
            parts_.push_back({number_of_[f][rows_[f].samples[i].word], samples[f], &rows_[f].samples[i]});
    }
    const double scale = all > 0 ? 1 / all : 0;
    for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t f = 0; f < rows_.size(); ++f)
            terms.push_back(samples[f] * static_cast<double>(rows_[f].rgba[x][c]));
        row.rgba[x][c] = static_cast<float>(sum_of(terms) * scale);
    }
    for (std::size_t k = 0; k < PathAtlas::parts; ++k) {
        row.counts[x][k] = 0;
        for (const display::AtlasRow& from : rows_) row.counts[x][k] += from.counts[x][k];
    }
    std::stable_sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.word < b.word; });
    for (std::size_t i = 0, end = 0; i < parts_.size(); i = end) {
        while (end < parts_.size() && parts_[end].word == parts_[i].word) ++end;
        display::PathStringSample& sample = row.samples.emplace_back();
        sample.word = parts_[i].word;
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t p = i; p < end; ++p) terms.push_back(parts_[p].samples * parts_[p].sample->rgb[c]);
            sample.rgb[c] = sum_of(terms) * scale;
        }
        const double luminance = mean_luminance(sample);
        for (std::size_t k = 0; k < PathAtlas::parts; ++k) {
            for (std::size_t p = i; p < end; ++p)
                terms.push_back(parts_[p].samples * mean_luminance(*parts_[p].sample) *
                                static_cast<double>(parts_[p].sample->parts[k]));
            const double part = sum_of(terms) * scale;
            sample.parts[k] = luminance == 0 ? 0 : static_cast<float>(part / luminance);
        }
    }
    row.begin.push_back(static_cast<std::uint32_t>(row.samples.size()));
}

display::ImageDescription MergedAtlas::description() const {
    display::ImageDescription description = files_.front()->description();
    std::set<Sampled> all;
    std::uint64_t per_pixel = 0, in_all = 0;
    for (const auto& file : files_) {
        for (const Sampled& each : sampled(*file)) all.insert(each);
        per_pixel += number_attribute(*file, "raylex/samples_per_pixel");
        in_all += number_attribute(*file, "raylex/camera_samples");
        description.complete = description.complete && file->description().complete;
    }
    std::set<std::uint64_t> seeds;
    std::vector<Sampled> joined;
    bool in_shards = false;
    for (const Sampled& each : all) {
        seeds.insert(each.seed);
        in_shards = in_shards || each.end != all_samples;
        if (!joined.empty() && joined.back().seed == each.seed && joined.back().end == each.first)
            joined.back().end = each.end;
        else joined.push_back(each);
    }
    std::string seed_list, shard_list;
    for (const std::uint64_t seed : seeds) seed_list += (seed_list.empty() ? "" : ",") + std::to_string(seed);
    for (const Sampled& each : joined) shard_list += (shard_list.empty() ? "" : ",") + to_text(each);
    description.attributes["raylex/seed"] = seed_list;
    description.attributes.erase(sampled_attribute);
    if (in_shards) description.attributes[sampled_attribute] = shard_list;
    description.attributes["raylex/samples_per_pixel"] = std::to_string(per_pixel);
    description.attributes["raylex/camera_samples"] = std::to_string(in_all);
    for (const char* of_one : {"raylex/time", "raylex/host", "raylex/command"}) description.attributes.erase(of_one);
    return description;
}

}  // namespace raylex::experiments
