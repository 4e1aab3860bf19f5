#include "experiments/job/sampling_requests.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>

#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {
namespace {

/// Returns the number at the beginning of `text` and sets `rest` to the text after it.
std::optional<double> leading_number(std::string_view text, std::string_view& rest) {
    double number = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failed != std::errc() || !std::isfinite(number)) return std::nullopt;
    rest = text.substr(static_cast<std::size_t>(end - text.data()));
    return number;
}

/// Reads a number under `key`, above 0 or from 0 on. Integers are allowed.
void read_number(TomlTable& table, const char* key, double least, double& value) {
    const toml::node* node = table.take(key);
    if (node == nullptr) return;
    const std::optional<double> number = node->is_string() ? std::nullopt : node->value<double>();
    if (number && std::isfinite(*number) && *number >= least) value = *number;
    else
        table.source().fail(table.location_of(key), "'" + std::string(key) + "' in " + table.description() +
                                                        " is not a number " + (least > 0 ? "above 0" : "from 0 on"));
}

/// Reads "name" or {name = "...", weight = 2}.
void read_metric_channel(TomlSource& source, const toml::node& node, display::AdaptiveSettings& adaptive) {
    display::AdaptiveChannel channel;
    channel.location = source.location(node);
    if (const auto* name = node.as_string()) {
        channel.name = name->get();
        channel.location = source.content_location(node);
    } else if (const auto* table = node.as_table()) {
        TomlTable reader(source, *table, "a channel of [adaptive]");
        reader.require("name", channel.name);
        read_number(reader, "weight", std::numeric_limits<double>::min(), channel.weight);
        reader.close();
    } else {
        source.fail(channel.location,
                    "a channel of [adaptive] is neither a name nor a table; expected for example \"beauty\" or "
                    "{name = \"beauty\", weight = 2}");
        return;
    }
    adaptive.channels.push_back(std::move(channel));
}

}  // namespace

Result<double> parse_interval(const std::string& text, const SourceLocation& where, const std::string& what) {
    constexpr double longest = 30.0 * 24 * 3600;
    std::string_view unit;
    const std::optional<double> number = leading_number(text, unit);
    double scale = 0;
    if (unit.empty() || unit == "s") scale = 1;
    else if (unit == "m" || unit == "min") scale = 60;
    else if (unit == "h") scale = 3600;
    if (!number || scale == 0 || *number * scale < 0.01 || *number * scale > longest)
        return error_at(where, "'" + text + "' is not a " + what +
                                   "; expected for example 60s, 5m or 1h, at least "
                                   "0.01s and at most 30 days");
    return *number * scale;
}

Result<double> parse_tolerance(const std::string& text, const SourceLocation& where) {
    std::string_view unit;
    const std::optional<double> number = leading_number(text, unit);
    if (!number || !(*number > 0) || (!unit.empty() && unit != "%" && unit != " %"))
        return error_at(where, "'" + text + "' is not a relative error; expected a number above 0 such as 1% or 0.01");
    if (unit.empty() && *number >= 1)
        return error_at(where, "'" + text + "' is not a relative error below 1; expected a number such as 1% or 0.01",
                        "did you mean '" + text + "%'?");
    return unit.empty() ? *number : *number / 100;
}

void apply_sample_limit(std::uint64_t samples_per_pixel, display::AdaptiveSettings& adaptive) {
    adaptive.max_samples = samples_per_pixel;
    adaptive.min_samples = std::min(adaptive.min_samples, samples_per_pixel);
}

void read_adaptive(TomlTable& root, Job& job) {
    const toml::table* table = root.take_table("adaptive");
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[adaptive]");
    display::AdaptiveSettings adaptive;
    adaptive.location = reader.location();
    std::string text;
    if (const toml::node* node = table->get("error"); node != nullptr && node->is_string()) {
        reader.read("error", text);
        auto parsed = parse_tolerance(text, reader.content_location_of("error"));
        if (parsed) adaptive.error = *parsed;
        else root.source().fail(parsed.error());
    } else {
        read_number(reader, "error", std::numeric_limits<double>::min(), adaptive.error);
    }
    if (const toml::node* node = reader.take("channels")) {
        if (const toml::array* list = node->as_array(); list != nullptr && !list->empty()) {
            for (const toml::node& each : *list) read_metric_channel(root.source(), each, adaptive);
        } else {
            root.source().fail(reader.location_of("channels"),
                               "'channels' in [adaptive] is not a list of channels; expected for example [\"beauty\"]");
        }
    }
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
    std::int64_t number = 0;
    if (reader.read("max_samples", number, 1, most)) adaptive.max_samples = static_cast<std::uint64_t>(number);
    else if (job.settings.samples.per_pixel) adaptive.max_samples = *job.settings.samples.per_pixel;
    if (reader.read("min_samples", number, 1, most)) adaptive.min_samples = static_cast<std::uint64_t>(number);
    else adaptive.min_samples = std::min(adaptive.min_samples, adaptive.max_samples);
    read_number(reader, "floor", 0, adaptive.floor);
    if (reader.read("neighbourhood", number, 0, 8)) adaptive.neighbourhood = static_cast<int>(number);
    reader.close();
    job.settings.stop.adaptive = std::move(adaptive);
}

transport::BucketSettings& bucket_settings(Job& job) {
    if (!job.settings.buckets) job.settings.buckets.emplace();
    return *job.settings.buckets;
}

std::string checkpoint_file(const Job& job) {
    return (job.shard ? job.shard->record : job.output) + ".checkpoint";
}

Status check_recovery(const Job& job) {
    const bool saves = job.checkpoint_seconds > 0 || job.resume;
    if (!saves && !job.settings.buckets) return success();
    if (saves && !job.outputs.deep.file.empty())
        return error_at(job.outputs.deep.location,
                        "a deep image is not saved in checkpoints, so --checkpoint and --resume "
                        "cannot be used with it",
                        "leave out the deep image, or --checkpoint and --resume");
    if (saves && !job.outputs.atlas.file.empty())
        return error_at(job.outputs.atlas.location,
                        "a path atlas is not saved in checkpoints, so --checkpoint and --resume cannot be used with it",
                        "leave out the atlas, or --checkpoint and --resume; atlases of renders with other seeds can be "
                        "merged: raylex ask --merge");
    const std::string file = checkpoint_file(job);
    std::error_code failed;
    const bool exists = std::filesystem::exists(file, failed);
    if (job.shard) return success();  // a shard continues from its checkpoint
    // A bucket folder without finished buckets, as after a full disk, has nothing to lose.
    const bool holds_samples =
        exists && !(std::filesystem::is_directory(file, failed) && std::filesystem::is_empty(file, failed));
    if (holds_samples && !job.resume)
        return error_at({file, 0, 0},
                        "this is the checkpoint of an unfinished render, which a new render would overwrite",
                        "--resume continues it; to start again, remove this file");
    if (!exists && job.resume)
        return error_at({file, 0, 0}, "there is no checkpoint to resume from; expected this file",
                        "omit --resume to start a new render");
    return success();
}

void request_checkpoints(Job& job) {
    if (job.checkpoint_seconds == 0 && !job.settings.buckets) return;
    transport::CheckpointSettings settings;
    settings.file = checkpoint_file(job);
    settings.seconds = job.checkpoint_seconds > 0 ? job.checkpoint_seconds : std::numeric_limits<double>::infinity();
    settings.resume = job.resume;
    job.settings.checkpoint = std::move(settings);
}

Status check_guide_only(const Job& job) {
    const bool has_more = job.shard || job.resume || job.settings.samples.only;
    if (!job.guide_only || (!job.settings.paths.guide_file.empty() && !has_more)) return success();
    return error_at({"--guide-only", 0, 0}, "it trains a guide for a file, and renders nothing",
                    "expected --guide-file FILE, and no --shard, --resume and --replay");
}

}  // namespace raylex::experiments
