#include "experiments/job/output_requests.h"

#include <filesystem>
#include <utility>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/drivers/tev_driver.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

Parameter text_parameter(const std::string& name, const std::string& value, const SourceLocation& where) {
    Parameter parameter;
    parameter.name = name;
    parameter.type = ParameterType::string;
    parameter.strings = {value};
    parameter.location = where;
    return parameter;
}

void read_storage(TomlTable& root, OutputRequests& outputs) {
    const toml::table* table = root.take_table("exr");
    if (table == nullptr) return;
    TomlTable exr(root.source(), *table, "[exr]");
    // "all" comes first, so that the other keys override it in any order.
    for (const char* kind : {"all", "light", "color", "normal", "position", "value", "id"}) {
        std::string text;
        if (!exr.read(kind, text)) continue;
        Status status = override_exr_storage(outputs.storage, kind, text, exr.content_location_of(kind));
        if (!status) root.source().fail(status.error());
    }
    std::string parts;
    if (exr.read("parts", parts)) {
        Status status = set_exr_parts(outputs, parts, exr.content_location_of("parts"));
        if (!status) root.source().fail(status.error());
    }
    exr.close();
}

void read_deep(TomlTable& root, const std::string& job_path, DeepRequest& deep) {
    const toml::table* table = root.take_table("deep");
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[deep]");
    deep.location = reader.location();
    if (reader.require("file", deep.file)) deep.file = beside_job(job_path, deep.file);
    reader.read("channels", deep.channels);
    reader.read("tidy", deep.options.tidy);
    std::int64_t samples = 0;
    if (reader.read("samples", samples, 1, 4096)) deep.options.most_samples = static_cast<int>(samples);
    if (const toml::node* node = reader.take("tolerance")) {
        const double tolerance = node->value<double>().value_or(0);
        if (tolerance >= 0x1p-23 && tolerance <= 1) deep.options.tolerance = tolerance;
        else
            root.source().fail(reader.location_of("tolerance"),
                               "'tolerance' in [deep] is not a relative difference of depths; expected 1.2e-7 to 1");
    }
    std::string storage;
    if (reader.read("storage", storage)) {
        auto parsed = display::parse_deep_storage(storage, reader.content_location_of("storage"));
        if (parsed) deep.storage = *parsed;
        else root.source().fail(parsed.error());
    }
    reader.close();
}

void read_atlas(TomlTable& root, const std::string& job_path, AtlasRequest& atlas) {
    const toml::table* table = root.take_table("atlas");
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[atlas]");
    atlas.location = reader.location();
    if (reader.require("file", atlas.file)) atlas.file = beside_job(job_path, atlas.file);
    std::string text;
    if (reader.read("by", text))
        if (Status set = set_atlas_rules(text, reader.content_location_of("by"), atlas); !set)
            root.source().fail(set.error());
    std::int64_t length = 0;  // 0: the maximum depth of the render's paths (AtlasOutput::prepare)
    static_cast<void>(reader.read("length", length, 1, display::WordRules::most_length));
    atlas.rules.length = static_cast<int>(length);
    if (reader.read("budget", text)) {
        auto budget = display::parse_memory_size(text, reader.content_location_of("budget"));
        if (budget) atlas.budget = *budget;
        else root.source().fail(budget.error());
    }
    reader.close();
}

void read_drivers(TomlTable& root, const std::string& job_path, OutputRequests& outputs) {
    for (const toml::table* table : root.take_tables("driver")) {
        TomlTable reader(root.source(), *table, "a [[driver]] table");
        display::DriverRequest request;
        if (!reader.require("type", request.name)) continue;
        request.parameters = reader.take_parameters();
        request.parameters.location = reader.location_of("type");
        for (Parameter& parameter : request.parameters.parameters)
            if (parameter.name == "file" && parameter.strings.size() == 1)
                parameter.strings[0] = beside_job(job_path, parameter.strings[0]);
        outputs.drivers.push_back(std::move(request));
    }
}

}  // namespace

Status set_exr_parts(OutputRequests& outputs, const std::string& word, const SourceLocation& where) {
    outputs.single_part = word == "single";
    if (word == "single" || word == "multi") return success();
    return error_at(where,
                    "'" + word +
                        "' is neither a number of parts nor a storage format; expected single, multi, or KIND='TYPE "
                        "COMPRESSION', such as light='half piz'",
                    near_miss(word, {"single", "multi"}));
}

Status set_atlas_rules(const std::string& text, const SourceLocation& where, AtlasRequest& atlas) {
    auto rules = display::parse_word_rules(text, where);
    if (!rules) return rules.error();
    rules->length = atlas.rules.length;
    atlas.rules = *rules;
    return success();
}

Status check_exr_requests(const OutputRequests& outputs) {
    for (const display::ExrStorage& each : outputs.storage)
        if (outputs.single_part && is_lossy(each.compression))
            return error_at({}, "a single part has one compression for all channels, and '" + storage_text(each) +
                                    "' would also lose bits of depths, ids and mattes; expected none, rle, zips, zip "
                                    "or piz, or one part for each channel");
    return success();
}

void read_viewer(TomlTable& output, OutputRequests& outputs) {
    std::string address;
    if (!output.read("tev", address)) return;
    auto parsed = display::tev_address(address, output.location_of("tev"));
    if (parsed) outputs.drivers.push_back({"tev", std::move(*parsed)});
    else output.source().fail(parsed.error());
}

void read_memory_limit(TomlTable& render, OutputRequests& outputs) {
    std::string text;
    if (!render.read("memory_limit", text)) return;
    auto limit = display::parse_memory_size(text, render.location_of("memory_limit"));
    if (limit) outputs.memory_limit = *limit;
    else render.source().fail(limit.error());
}

std::string beside_job(const std::string& job_path, const std::string& path) {
    if (path.empty() || fs::path(path).is_absolute()) return path;
    return (fs::path(job_path).parent_path() / path).lexically_normal().string();
}

display::DriverRequest preview_request(const std::string& text, const SourceLocation& where) {
    display::DriverRequest request{"png", {}};
    request.parameters.location = where;
    const std::size_t equals = text.find('=');
    // A path can contain '=' too, so the text before '=' must look like a layer name.
    const bool layer = equals != std::string::npos && equals > 0 && text.find('/') > equals;
    request.parameters.parameters.push_back(text_parameter("file", layer ? text.substr(equals + 1) : text, where));
    if (layer) request.parameters.parameters.push_back(text_parameter("layer", text.substr(0, equals), where));
    return request;
}

void read_output_tables(TomlTable& root, const std::string& job_path, OutputRequests& outputs) {
    read_storage(root, outputs);
    read_deep(root, job_path, outputs.deep);
    read_atlas(root, job_path, outputs.atlas);
    read_drivers(root, job_path, outputs);
}

}  // namespace raylex::experiments
