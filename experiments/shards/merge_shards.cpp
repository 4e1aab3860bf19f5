#include "experiments/shards/merge_shards.h"

#include <algorithm>
#include <map>
#include <memory>

#include "display/checkpoint/banded_record.h"
#include "display/filters/display_filter.h"
#include "display/output/splits/stored_precision.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

Error at_file(Error error, const std::string& path) {
    error.file = path;
    return error;
}

/// An open record without its sums, which are read during the merge.
struct OpenRecord {
    std::string path;
    display::BandedRecord sums;
    RecordedImage image;
    ShardFacts facts;
};

Result<OpenRecord> open_shard_record(const std::string& path) {
    auto file = display::RecordFileReader::open(path);
    if (!file) return file.error();
    const char* const expected = "expected a record of 'raylex render --shard'";
    if (!file->has("image")) return error_at({path, 0, 0}, "this is not a record of a shard", expected);
    auto image = file->read("image");
    if (!image) return image.error();
    RecordedImage recorded;
    ShardFacts facts;
    try {
        const Json json = parse_json(*image);
        recorded = image_of(json);
        facts = shard_facts(json);
    } catch (const std::exception& error) {
        return error_at({path, 0, 0},
                        std::string("this is not a record of a shard, or its image is damaged: ") + error.what(),
                        expected);
    }
    auto sums = display::BandedRecord::open(*std::move(file));
    if (!sums) return sums.error();
    return OpenRecord{path, *std::move(sums), std::move(recorded), facts};
}

/// Adds the coverage in a record to the cryptomattes. Makes the cryptomattes for the first record.
Status add_mattes(const OpenRecord& shard, std::vector<geoaovs::Cryptomatte>& mattes) {
    const display::FrameBufferLayout& layout = shard.sums.layout();
    const bool first = mattes.empty();
    if (!first && mattes.size() != shard.image.mattes.size())
        return error_at({shard.path, 0, 0}, "this shard has different cryptomattes");
    for (std::size_t i = 0; i < shard.image.mattes.size(); ++i) {
        const RecordedMatte& each = shard.image.mattes[i];
        geoaovs::Cryptomatte matte(each.kind, each.ranks, layout.width, layout.height,
                                   geoaovs::MatteNames{each.names, {}});
        const auto bytes = shard.sums.file().read(matte.name());
        if (!bytes) return bytes.error();
        if (Status s = matte.coverage().restore_record(*bytes); !s) return at_file(s.error(), shard.path);
        if (first) mattes.push_back(std::move(matte));
        else if (Status s = mattes[i].coverage().merge(matte.coverage()); !s) return at_file(s.error(), shard.path);
    }
    return success();
}

/// Ranges of samples read so far, by first sample.
class Ranges {
  public:
    Status add(const ShardRange& range, const std::string& path) {
        const auto clash = std::find_if(known_.begin(), known_.end(), [&](const auto& each) {
            return each.second.range.first < range.end && range.first < each.second.range.end;
        });
        if (clash != known_.end())
            return error_at({path, 0, 0},
                            "this shard has " + text(range.first, range.end) + ", and '" + clash->second.path +
                                "' has " + text(clash->second.range.first, clash->second.range.end) + ": they overlap",
                            "every sample may occur once; leave out one of the two");
        known_[range.first] = {range, path};
        return success();
    }
    /// Returns success if the ranges are all samples of the render.
    [[nodiscard]] Status whole(std::uint64_t total) const {
        std::uint64_t reached = 0;
        for (const auto& [first, each] : known_) {
            if (first > reached) return missing(reached, first, total);
            reached = each.range.end;
        }
        return reached < total ? missing(reached, total, total) : success();
    }

  private:
    struct Known {
        ShardRange range;
        std::string path;
    };
    static std::string text(std::uint64_t first, std::uint64_t end) {
        return "samples " + std::to_string(first) + " to " + std::to_string(end - 1);
    }
    static Error missing(std::uint64_t first, std::uint64_t end, std::uint64_t total) {
        return error_at({}, text(first, end) + " of " + std::to_string(total) + " are in no record",
                        "run the shard with these samples, and add its record");
    }
    std::map<std::uint64_t, Known> known_;
};

/// Returns the kind of a difference in words, for the differences that people cause most often.
std::string kind_of_difference(const std::string& difference) {
    for (const auto& [field, kind] : {std::pair<const char*, const char*>{"raylex: ", "build of raylex"},
                                      {"scene: ", "scene"},
                                      {"seed: ", "seed"},
                                      {"instruction set: ", "instruction set"},
                                      {"plugin ", "plugin"}})
        if (difference.starts_with(field)) return kind;
    return "config";
}

Status same_render(const OpenRecord& first, const OpenRecord& other) {
    const auto differences = display::identity_differences(other.sums.file().identity(), first.sums.file().identity());
    if (differences.empty()) return success();
    std::vector<std::string> kinds;
    for (const std::string& each : differences) {
        std::string kind = kind_of_difference(each);
        if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(std::move(kind));
    }
    std::string what;
    for (const std::string& kind : kinds) what += (what.empty() ? "" : ", ") + kind;
    std::string message =
        "this shard and '" + first.path + "' (here) belong to different renders: different " + what + ":";
    for (const std::string& each : differences) message += "\n  " + each;
    return error_at({other.path, 0, 0}, message, "expected shards of one render and one build of raylex");
}

void add_hosts(const std::map<std::string, std::string>& attributes, std::string& hosts) {
    const auto found = attributes.find("raylex/host");
    if (found == attributes.end() || ("\n" + hosts + "\n").find("\n" + found->second + "\n") != std::string::npos)
        return;
    hosts += (hosts.empty() ? "" : "\n") + found->second;
}

void add_facts(ShardFacts& sum, const ShardFacts& shard) {
    sum.camera_samples += shard.camera_samples;
    sum.invalid_samples += shard.invalid_samples;
    sum.wall_seconds += shard.wall_seconds;
    sum.cpu_seconds += shard.cpu_seconds;
    sum.guide_cpu_seconds += shard.guide_cpu_seconds;
}

/// Sets the header attributes of the merged image.
void describe(MergedRender& merged, const std::string& hosts, std::uint64_t light_paths) {
    std::map<std::string, std::string>& attributes = merged.image.description.attributes;
    attributes["raylex/samples_per_pixel"] = std::to_string(merged.facts.range.total);
    attributes["raylex/camera_samples"] = std::to_string(merged.facts.camera_samples);
    attributes["raylex/shards"] = std::to_string(merged.shards);
    attributes["raylex/host"] = hosts;
    attributes.erase("raylex/resumed_samples");
    if (light_paths > 0) attributes["raylex/light_paths"] = std::to_string(light_paths);
}

}  // namespace

Result<MergedRender> merge_shards(const std::vector<std::string>& records) {
    if (records.empty()) return error_at({}, "no records to merge; expected at least one");
    std::vector<OpenRecord> shards;
    Ranges ranges;
    MergedRender merged;
    std::uint64_t light_paths = 0;
    std::map<std::uint64_t, std::map<std::string, std::string>> attributes;
    for (const std::string& path : records) {
        auto shard = open_shard_record(path);
        if (!shard) return shard.error();
        if (!shards.empty())
            if (Status same = same_render(shards.front(), *shard); !same) return same.error();
        if (Status fits = ranges.add(shard->facts.range, path); !fits) return fits.error();
        attributes[shard->facts.range.first] = shard->image.description.attributes;
        light_paths += shard->sums.light_path_count();
        merged.parts.emplace_back(shard->facts.part, shard->facts.parts);
        merged.has_atlas = merged.has_atlas || shard->facts.has_atlas;
        if (shards.empty()) merged.facts = shard->facts;
        else add_facts(merged.facts, shard->facts);
        shards.push_back(*std::move(shard));
    }
    const std::uint64_t total = merged.facts.range.total;
    if (Status all = ranges.whole(total); !all) return all.error();
    for (const OpenRecord& shard : shards)
        if (Status s = add_mattes(shard, merged.mattes); !s) return s.error();
    merged.facts.range = {0, total, total};
    merged.shards = shards.size();
    merged.image = shards.front().image;
    std::string hosts;
    double magnitude = 0;
    for (const auto& [first, each] : attributes) {
        add_hosts(each, hosts);
        magnitude = std::max(magnitude, display::light_magnitude_of(each));
    }
    merged.image.description.attributes = attributes.begin()->second;
    describe(merged, hosts, light_paths);
    if (magnitude > 0) merged.image.description.attributes[display::light_magnitude] = number_text(magnitude);
    std::vector<display::BandedRecord> sums;
    for (OpenRecord& shard : shards) sums.push_back(std::move(shard.sums));
    const display::BandedRecord& first = sums.front();
    const display::FrameBufferLayout layout = first.layout();
    std::vector<display::ChannelDefinition> channels = first.channels();
    const std::vector<display::RowRange> bands = first.bands();
    merged.pixels = std::make_unique<const display::BandedImage>(
        layout, std::move(channels), bands,
        [sums = std::move(sums)](const display::RowRange& rows) { return display::sum_of_band(sums, rows); });
    return merged;
}

Status write_merged_image(const std::string& path, const MergedRender& merged) {
    std::vector<std::unique_ptr<display::DisplayFilter>> filters;
    for (const ObjectRequest& request : merged.image.filters) {
        auto filter = display::make_display_filter(request.name, request.parameters,
                                                   {merged.pixels->channels(), merged.image.beauty});
        if (!filter) return filter.error();
        filters.push_back(*std::move(filter));
    }
    display::ImageDescription description = merged.image.description;
    for (const geoaovs::Cryptomatte& matte : merged.mattes)
        description.data_parts.push_back(
            {matte.name(), matte.planes(), matte.attributes(),
             [&matte](const display::PixelRegion& rows) { return matte.values(rows.y0, rows.y1); }});
    return display::write_exr(path, display::FilteredImage(*merged.pixels, filters), merged.image.beauty, description);
}

}  // namespace raylex::experiments
