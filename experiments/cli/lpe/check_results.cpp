#include "experiments/cli/lpe/check_results.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/algebra/wording/regex_printing.h"
#include "lpe/language/extensions.h"

namespace raylex::experiments {
namespace {

const char* word_for(lpe::SplitProof verdict) {
    switch (verdict) {
        case lpe::SplitProof::partition:
            return "partition";
        case lpe::SplitProof::missed:
            return "missed";
        case lpe::SplitProof::counted_twice:
            return "counted twice";
        case lpe::SplitProof::outside:
            return "outside";
    }
    return "";
}

/// Finds an expression of the paths that no layer counts, in the dialect of the application that reads the channels if
/// possible, otherwise for raylex.
void find_rest(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    const bool renderman = written_for_renderman(options) != Written::nothing ||
                           (set.of_renderman && options.reader.value() == lpe::Reader::renderman);
    const auto& layers = picture.layers;
    if (renderman) {
        auto rest = lpe::rest_expression(layers.sources, layers.whole, options.words, lpe::Reader::renderman);
        if (rest && *rest) {
            picture.rest = **rest;
            return;
        }
    }
    auto rest = lpe::rest_expression(layers.sources, layers.whole, options.words);
    if (!rest || !*rest) {
        picture.rest_note = "the remaining paths have no short expression (" +
                            (rest ? "at most " + std::to_string(lpe::longest_printed_expression) + " characters"
                                  : rest.error().message) +
                            ")";
        return;
    }
    picture.rest = **rest;
    std::string ours;
    for (const std::string& each : lpe::extensions_in(picture.rest)) ours += (ours.empty() ? "" : ", ") + each;
    if (renderman) picture.rest_note = "raylex reads it; RenderMan has no " + ours;
    else if (std::any_of(layers.sources.begin(), layers.sources.end(),
                         [](const lpe::ChannelSource& each) { return each.dialect == lpe::Dialect::osl; }))
        picture.rest_note = "it is in the dialect renderman";
}

/// Finds the result for channels that are too large for a proof of all together: one overlapping pair suffices to
/// refute the partition.
Status check_pairs(const CheckOptions& options, CheckPicture& picture, const Error& too_large) {
    const Layers& layers = picture.layers;
    auto overview = lpe::look_over(layers.sources, layers.whole, options.words);
    if (!overview || overview->overlaps.empty()) return too_large;
    picture.overview = std::move(*overview);
    const auto& overlaps = picture.overview.overlaps;
    const auto shortest = std::min_element(overlaps.begin(), overlaps.end(), [](const auto& a, const auto& b) {
        return a.witness.events.size() < b.witness.events.size();
    });
    picture.result = word_for(lpe::SplitProof::counted_twice);
    picture.witness = shortest->witness;
    picture.summary = "'" + layers.sources[shortest->first].name + "' and '" + layers.sources[shortest->second].name +
                      "' both count " + picture.witness.sentence + " (" + picture.witness.text + ")";
    return success();
}

Status run_partition_check(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    Layers& layers = picture.layers;
    auto report = lpe::check_partition(layers.sources, layers.whole, options.words);
    if (!report) return check_pairs(options, picture, report.error());
    const bool fails = report->result != lpe::SplitProof::partition;
    if (fails) {
        auto overview = lpe::look_over(layers.sources, layers.whole, options.words);
        if (!overview) return overview.error();
        picture.overview = std::move(*overview);
    }
    const bool only_missed = fails && picture.overview.overlaps.empty() && picture.overview.outside.empty();
    if (only_missed) {
        find_rest(options, set, picture);
        if (!options.rest.empty() && !picture.rest.empty()) {
            layers.sources.push_back(bare_expression(picture.rest, lpe::Dialect::renderman, options.rest, "--rest"));
            picture.overview = {};
            report = lpe::check_partition(layers.sources, layers.whole, options.words);
            if (!report) return report.error();
        }
    }
    picture.holds = report->result == lpe::SplitProof::partition;
    picture.result = word_for(report->result);
    picture.summary = std::move(report->summary);
    picture.witness = std::move(report->witness);
    picture.warnings = std::move(report->warnings);
    return success();
}

/// Checks the layers that belong to no partition by themselves, because their overlaps and gaps are the ones to fix.
Status check_left(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    const std::vector<std::size_t>& left = picture.sorting.left;
    CheckPicture alone;
    alone.layers.whole = picture.layers.whole;
    std::string names;
    for (const std::size_t channel : left) {
        const lpe::ChannelSource& source = picture.layers.sources[channel];
        names += (names.empty() ? "'" : ", '") + source.name + "'";
        alone.layers.sources.push_back(source);
    }
    CheckOptions plain = options;
    plain.rest.clear();
    if (Status checked = run_partition_check(plain, set, alone); !checked) return checked;
    for (lpe::SharedPath& each : alone.overview.overlaps) {
        each.first = left[each.first];
        each.second = left[each.second];
    }
    for (lpe::OutsidePath& each : alone.overview.outside) each.channel = left[each.channel];
    for (std::size_t& each : alone.overview.empty) each = left[each];
    picture.overview = std::move(alone.overview);
    picture.rest = std::move(alone.rest);
    picture.rest_note = std::move(alone.rest_note);
    picture.result = std::move(alone.result);
    picture.summary = (left.size() <= 4 ? names : std::to_string(left.size()) + " layers") +
                      (left.size() == 1 ? " is" : " are") + " in no partition; these alone: " + alone.summary;
    picture.witness = std::move(alone.witness);
    return success();
}

/// Sorts overlapping layers into several partitions of the same beauty, for example by lobe and by light group. The
/// check holds if each layer belongs to one of them. Only layers from files are sorted; layers on the command line form
/// one split.
Status sort_layers(const CheckOptions& options, const ChannelSet& set, CheckPicture& picture) {
    if (picture.holds || picture.files.empty() || picture.overview.overlaps.empty()) return success();
    auto sorting = lpe::sort_into_partitions(picture.layers.sources, picture.layers.whole, options.words);
    if (!sorting) return success();  // too large to sort: the result stays
    picture.sorting = std::move(*sorting);
    const lpe::Sorting& sorted = picture.sorting;
    if (sorted.partitions.empty()) return success();
    if (!sorted.left.empty()) return check_left(options, set, picture);
    picture.holds = true;
    picture.result = "partitions";
    picture.summary = "the layers are " + std::to_string(sorted.partitions.size()) +
                      " partitions of the beauty, each of which counts every path exactly once";
    picture.overview = {};
    return success();
}

Status run_disjoint_check(const CheckOptions& options, CheckPicture& picture, const std::string& rest) {
    auto report = lpe::check_disjoint(picture.layers.sources, options.words);
    if (!report) return report.error();
    if (!report->disjoint) {
        auto overview = lpe::look_over(picture.layers.sources, std::nullopt, options.words);
        if (!overview) return overview.error();
        picture.overview = std::move(*overview);
        picture.overview.holes.clear();
    }
    picture.holds = report->disjoint;
    picture.result = report->disjoint ? "disjoint" : "overlaps";
    picture.summary = report->summary + (report->disjoint && !rest.empty() ? "; '" + rest + "' takes the rest" : "");
    picture.witness = std::move(report->witness);
    picture.warnings = std::move(report->warnings);
    return success();
}

Status run_covers_check(const CheckOptions& options, CheckPicture& picture) {
    auto proof = lpe::check_covers(picture.layers.sources, picture.layers.whole, options.words);
    if (!proof) return proof.error();
    if (!proof->holds) {
        auto overview = lpe::look_over(picture.layers.sources, picture.layers.whole, options.words);
        if (!overview) return overview.error();
        picture.overview.holes = std::move(overview->holes);
    }
    picture.holds = proof->holds;
    picture.result = proof->holds ? "covers" : "missed";
    picture.summary = std::move(proof->summary);
    picture.witness = std::move(proof->witness);
    picture.warnings = std::move(proof->warnings);
    return success();
}

/// Returns the channels of a partition by name. Errors: an unknown name.
Result<std::vector<lpe::ChannelSource>> members(const std::vector<lpe::ChannelSource>& sources,
                                                const PartitionRequest& partition,
                                                const std::vector<std::string>& wanted) {
    std::vector<lpe::ChannelSource> result;
    for (const std::string& name : wanted) {
        std::vector<std::string> known;
        for (const lpe::ChannelSource& source : sources) {
            known.push_back(source.name);
            if (source.name == name) result.push_back(source);
        }
        if (result.empty() || result.back().name != name)
            return error_at(partition.location,
                            "partition '" + partition.name + "' names the channel '" + name + "', which does not exist",
                            near_miss(name, known));
    }
    return result;
}

/// Checks each partition that the TOML files declare.
Result<std::vector<CheckPicture>> check_declared(const CheckOptions& options, const ChannelSet& set,
                                                 const std::vector<lpe::ChannelSource>& sources) {
    std::vector<CheckPicture> pictures;
    for (const PartitionRequest& partition : set.partitions) {
        CheckPicture& picture = pictures.emplace_back();
        picture.partition = partition.name;
        picture.words = options.words;
        auto channels = members(sources, partition, partition.channels);
        if (!channels) return channels.error();
        picture.layers.sources = std::move(*channels);
        if (!partition.of.empty()) {
            auto found = members(sources, partition, {partition.of});
            if (!found) return found.error();
            picture.layers.whole = found->front();
        }
        const Status checked = partition.rest.empty() ? run_partition_check(options, set, picture)
                                                      : run_disjoint_check(options, picture, partition.rest);
        if (!checked) return checked.error();
    }
    return pictures;
}

/// Checks the partitions that TOML files declare, or else all layers together.
Result<std::vector<CheckPicture>> run_checks(const CheckOptions& options, const ChannelSet& set,
                                             std::vector<lpe::ChannelSource> sources,
                                             std::optional<lpe::ChannelSource> of) {
    const bool declared =
        !set.partitions.empty() && options.of.empty() && options.rest.empty() && options.what == "partition";
    if (declared) return check_declared(options, set, sources);
    std::vector<CheckPicture> pictures(1);
    CheckPicture& picture = pictures.front();
    picture.channels = sources.size();
    picture.files = options.channels.files;
    picture.words = options.words;
    if (options.what == "partition" || of) {
        auto layers = choose_layers(set, std::move(sources), std::move(of), options.words);
        if (!layers) return layers.error();
        picture.layers = std::move(*layers);
    } else {
        picture.layers.sources = std::move(sources);
    }
    const Status checked = options.what == "covers"     ? run_covers_check(options, picture)
                           : options.what == "disjoint" ? run_disjoint_check(options, picture, "")
                                                        : run_partition_check(options, set, picture);
    if (!checked) return checked.error();
    if (options.what == "partition")
        if (Status sorted = sort_layers(options, set, picture); !sorted) return sorted.error();
    return pictures;
}

/// Returns the channels of one file with the macros of the whole set. Several files are checked one by one, then
/// together.
ChannelSet part_of(const ChannelSet& set, const std::string& file) {
    ChannelSet part = set;
    std::erase_if(part.file.channels, [&](const lpe::FileChannel& each) {
        const std::pair<std::string, std::string> here{each.source.name, file};
        return each.source.origin != file &&
               std::find(set.also_in.begin(), set.also_in.end(), here) == set.also_in.end();
    });
    std::erase_if(part.partitions, [&](const PartitionRequest& each) { return each.location.file != file; });
    return part;
}

}  // namespace

Written written_for_renderman(const CheckOptions& options) {
    const auto written = [&](const char* format) {
        return options.output.format == format ||
               (options.output.format.empty() && options.output.path.ends_with(std::string(".") + format));
    };
    if (options.reader.value() != lpe::Reader::renderman) return Written::nothing;
    if (written("ini")) return Written::with_macros;
    return written("rib") || written("usda") || written("usd") ? Written::without_macros : Written::nothing;
}

Result<std::vector<CheckPicture>> check_files(const CheckOptions& options, const ChannelSet& set,
                                              const std::vector<lpe::ChannelSource>& sources,
                                              const std::optional<lpe::ChannelSource>& of) {
    std::vector<CheckPicture> pictures;
    CheckPicture all;
    std::size_t files = 0;
    all.holds = options.channels.named.empty() && options.rest.empty();
    for (const std::string& file : options.channels.files) {
        const ChannelSet part = part_of(set, file);
        if (part.file.channels.empty() || options.what != "partition") continue;
        CheckOptions alone = options;
        alone.channels.files = {file};
        alone.rest.clear();
        std::vector<lpe::ChannelSource> own;
        for (const lpe::FileChannel& each : part.file.channels)
            for (const lpe::ChannelSource& source : sources)
                if (each.source.name == source.name) own.push_back(source);
        auto checked = run_checks(alone, part, std::move(own), of);
        if (!checked) return checked;
        ++files;
        for (CheckPicture& picture : *checked) {
            all.holds = all.holds && picture.holds;
            all.layers.sources.insert(all.layers.sources.end(), picture.layers.sources.begin(),
                                      picture.layers.sources.end());
            picture.alone = picture.partition.empty();
            pictures.push_back(std::move(picture));
        }
    }
    if (files < 2) return run_checks(options, set, sources, of);
    std::vector<CheckPicture> together;
    if (all.holds) {  // a layer shared by several splits, such as emission, is not an overlap
        all.result = "partitions";
        all.files = options.channels.files;
        all.channels = sources.size();
        all.summary = "each of the " + std::to_string(files) + " files splits the beauty by itself";
        together.push_back(std::move(all));
    } else {
        auto checked = run_checks(options, set, sources, of);
        if (!checked) return checked;
        together = std::move(*checked);
        std::erase_if(together, [](const CheckPicture& each) { return !each.partition.empty(); });
    }
    std::move(together.begin(), together.end(), std::back_inserter(pictures));
    return pictures;
}

}  // namespace raylex::experiments
