#include "experiments/shards/merge_shards.h"

#include <algorithm>
#include <map>
#include <memory>

#include "display/checkpoint/record_file.h"
#include "display/filters/display_filter.h"

namespace raylex::experiments {
namespace {

Error at_file(Error error, const std::string& path) {
    error.file = path;
    return error;
}

/// One record, read.
struct ReadRecord {
    std::string path;
    display::RecordIdentity identity;
    display::FrameBuffer frame_buffer;
    std::vector<geoaovs::Cryptomatte> mattes;
    RecordedImage image;
    ShardFacts facts;
};

Result<std::vector<geoaovs::Cryptomatte>> mattes_of_record(const display::RecordFile& record,
                                                           const std::vector<RecordedMatte>& recorded,
                                                           const display::FrameBufferLayout& layout) {
    std::vector<geoaovs::Cryptomatte> mattes;
    for (const RecordedMatte& each : recorded) {
        geoaovs::Cryptomatte& matte = mattes.emplace_back(each.kind, each.ranks, layout.width, layout.height,
                                                          geoaovs::MatteNames{each.names, {}});
        const display::RecordSection* section = record.find(matte.name());
        if (section == nullptr) return error_at({}, "the record has no section '" + matte.name() + "'");
        if (Status s = matte.coverage().restore_record(section->content); !s) return s.error();
    }
    return mattes;
}

Result<ReadRecord> read_shard_record(const std::string& path) {
    auto record = display::read_record_file(path);
    if (!record) return record.error();
    const display::RecordSection *image = record->find("image"), *sums = record->find("frame buffer");
    if (image == nullptr || sums == nullptr)
        return error_at({path, 0, 0}, "this record is not of a shard of a render",
                        "expected what 'raylex render --shard' writes");
    RecordedImage recorded;
    ShardFacts facts;
    try {
        const Json json = parse_json(image->content);
        recorded = image_of(json);
        facts = shard_facts(json);
    } catch (const std::exception& error) {
        return error_at(
            {path, 0, 0},
            std::string("this record is not of a shard of a render, or its image is damaged: ") + error.what(),
            "expected what 'raylex render --shard' writes");
    }
    auto buffer = display::FrameBuffer::from_record(sums->content);
    if (!buffer) return at_file(buffer.error(), path);
    auto mattes = mattes_of_record(*record, recorded.mattes, buffer->layout());
    if (!mattes) return at_file(mattes.error(), path);
    return ReadRecord{path, std::move(record->identity), *std::move(buffer), *std::move(mattes), std::move(recorded),
                      facts};
}

/// Ranges of samples seen so far, by their first one.
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
                            "merge takes every sample once: leave out one of the two");
        known_[range.first] = {range, path};
        return success();
    }
    /// Whether they are all samples of the render.
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
        return error_at({}, text(first, end) + " of " + std::to_string(total) + " are in none of the records",
                        "run the shard that has them, and name its record too");
    }
    std::map<std::uint64_t, Known> known_;
};

Status same_render(const display::RecordIdentity& first, const std::string& first_path, const ReadRecord& other) {
    const auto differences = display::identity_differences(other.identity, first);
    if (differences.empty()) return success();
    std::string message = "this shard is of another render than '" + first_path + "' (here):";
    for (const std::string& each : differences) message += "\n  " + each;
    return error_at({other.path, 0, 0}, message, "merge takes the shards of one render, by one build of raylex");
}

void add_hosts(const std::map<std::string, std::string>& attributes, std::string& hosts) {
    const auto found = attributes.find("raylex/host");
    if (found == attributes.end() || ("\n" + hosts + "\n").find("\n" + found->second + "\n") != std::string::npos)
        return;
    hosts += (hosts.empty() ? "" : "\n") + found->second;
}

Status add(MergedRender& merged, const ReadRecord& shard) {
    if (Status s = merged.frame_buffer.merge(shard.frame_buffer); !s) return at_file(s.error(), shard.path);
    if (shard.mattes.size() != merged.mattes.size())
        return error_at({shard.path, 0, 0}, "this shard has other cryptomattes");
    for (std::size_t i = 0; i < merged.mattes.size(); ++i)
        if (Status s = merged.mattes[i].coverage().merge(shard.mattes[i].coverage()); !s)
            return at_file(s.error(), shard.path);
    merged.facts.camera_samples += shard.facts.camera_samples;
    merged.facts.invalid_samples += shard.facts.invalid_samples;
    merged.facts.wall_seconds += shard.facts.wall_seconds;
    merged.facts.cpu_seconds += shard.facts.cpu_seconds;
    return success();
}

/// What the header says of the whole.
void describe(MergedRender& merged, const std::string& hosts) {
    std::map<std::string, std::string>& attributes = merged.image.description.attributes;
    attributes["raylex/samples_per_pixel"] = std::to_string(merged.facts.range.total);
    attributes["raylex/camera_samples"] = std::to_string(merged.facts.camera_samples);
    attributes["raylex/shards"] = std::to_string(merged.shards);
    attributes["raylex/host"] = hosts;
    attributes.erase("raylex/resumed_samples");
    if (const std::uint64_t paths = merged.frame_buffer.light_path_count(); paths > 0)
        attributes["raylex/light_paths"] = std::to_string(paths);
}

}  // namespace

Result<MergedRender> merge_shards(const std::vector<std::string>& records) {
    std::optional<MergedRender> merged;
    display::RecordIdentity identity;
    Ranges ranges;
    std::map<std::uint64_t, std::map<std::string, std::string>> attributes;
    for (const std::string& path : records) {
        auto shard = read_shard_record(path);
        if (!shard) return shard.error();
        if (merged)
            if (Status same = same_render(identity, records.front(), *shard); !same) return same.error();
        if (Status fits = ranges.add(shard->facts.range, path); !fits) return fits.error();
        attributes[shard->facts.range.first] = shard->image.description.attributes;
        if (merged) {
            if (Status s = add(*merged, *shard); !s) return s.error();
        } else {
            identity = std::move(shard->identity);
            merged.emplace(MergedRender{std::move(shard->frame_buffer), std::move(shard->mattes),
                                        std::move(shard->image), shard->facts, 0});
        }
        ++merged->shards;
    }
    if (!merged) return error_at({}, "no records to merge; expected at least one");
    const std::uint64_t total = merged->facts.range.total;
    if (Status all = ranges.whole(total); !all) return all.error();
    merged->facts.range = {0, total, total};
    std::string hosts;
    for (const auto& [first, each] : attributes) add_hosts(each, hosts);
    merged->image.description.attributes = attributes.begin()->second;
    describe(*merged, hosts);
    return *std::move(merged);
}

Status write_merged_image(const std::string& path, const MergedRender& merged) {
    std::vector<std::unique_ptr<display::DisplayFilter>> filters;
    for (const ObjectRequest& request : merged.image.filters) {
        auto filter = display::make_display_filter(request.name, request.parameters,
                                                   {merged.frame_buffer.channels(), merged.image.beauty});
        if (!filter) return filter.error();
        filters.push_back(*std::move(filter));
    }
    display::ImageDescription description = merged.image.description;
    for (const geoaovs::Cryptomatte& matte : merged.mattes)
        description.data_parts.push_back(
            {matte.name(), matte.planes(), matte.attributes(), [&matte] { return matte.values(); }});
    return display::write_exr(path, display::FilteredImage(merged.frame_buffer, filters), merged.image.beauty,
                              description);
}

}  // namespace raylex::experiments
