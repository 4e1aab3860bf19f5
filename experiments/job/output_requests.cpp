#include "experiments/job/output_requests.h"

#include <filesystem>
#include <utility>

#include "experiments/job/job.h"
#include "experiments/job/settings/setting.h"
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
    // "preset" and "all" come first, so that the other keys override them in any order.
    for (const char* kind : {"preset", "all", "light", "color", "normal", "position", "value", "id"}) {
        std::string text;
        if (!exr.read(kind, text)) continue;
        const SourceLocation where = exr.content_location_of(kind);
        Status status = kind == std::string_view("preset") ? use_exr_preset(outputs.storage, text, where)
                                                           : override_exr_storage(outputs.storage, kind, text, where);
        if (!status) root.source().fail(status.error());
    }
    std::string parts;
    if (exr.read("parts", parts)) {
        Status status = set_exr_parts(outputs, parts, exr.content_location_of("parts"));
        if (!status) root.source().fail(status.error());
    }
    exr.close();
}

void read_drivers(TomlTable& root, const std::string& job_path, OutputRequests& outputs) {
    for (ObjectRequest& request : read_objects(root, "driver")) {
        for (Parameter& parameter : request.parameters.parameters)
            if (parameter.name == "file" && parameter.strings.size() == 1)
                parameter.strings[0] = relative_to_job(job_path, parameter.strings[0]);
        outputs.drivers.push_back(std::move(request));
    }
}

}  // namespace

Status set_exr_parts(OutputRequests& outputs, const std::string& word, const SourceLocation& where) {
    outputs.single_part = word == "single";
    if (word == "single" || word == "multi") return success();
    return error_at(where,
                    "'" + word +
                        "' is neither a number of parts nor a storage format; expected single, multi, nuke, blender, "
                        "archive, or KIND='TYPE COMPRESSION', such as light='half piz'",
                    near_miss(word, {"single", "multi", "nuke", "blender", "archive"}));
}

Status set_atlas_rules(const std::string& text, const SourceLocation& where, AtlasRequest& atlas) {
    auto rules = display::parse_path_string_rules(text, where);
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

std::vector<ObjectRequest> read_objects(TomlTable& root, const char* key) {
    std::vector<ObjectRequest> objects;
    for (const toml::table* table : root.take_tables(key)) {
        TomlTable reader(root.source(), *table, "a [[" + std::string(key) + "]] table");
        ObjectRequest object;
        if (!reader.require("type", object.name)) continue;
        object.parameters = reader.take_parameters();
        object.parameters.location = reader.location_of("type");
        objects.push_back(std::move(object));
    }
    return objects;
}

std::string relative_to_job(const std::string& job_path, const std::string& path) {
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

void read_output_tables(TomlTable& root, const std::string& job_path, Job& job) {
    read_storage(root, job.outputs);
    const auto require_file = [](TomlTable& table) {
        std::string file;
        table.require("file", file);
    };
    job.outputs.deep.location = read_settings_table(root, "deep", job_path, job, require_file);
    job.outputs.atlas.location = read_settings_table(root, "atlas", job_path, job, require_file);
    read_drivers(root, job_path, job.outputs);
}

}  // namespace raylex::experiments
