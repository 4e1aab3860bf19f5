#include "experiments/job/pass_request.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <set>
#include <utility>

#include "experiments/job/job.h"
#include "experiments/job/text/toml_table.h"

namespace raylex::experiments {
namespace {

constexpr std::int64_t most_pass_samples = std::numeric_limits<std::int32_t>::max();

bool is_key(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    });
}

/// Converts a text to a parameter of a method: a boolean, a number or a string.
Parameter method_parameter(const std::string& key, const std::string& value, const SourceLocation& where) {
    Parameter parameter;
    parameter.name = key;
    parameter.location = where;
    double number = 0;
    const auto [end, failed] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (value == "true" || value == "false") {
        parameter.type = ParameterType::boolean;
        parameter.booleans = {static_cast<std::uint8_t>(value == "true")};
    } else if (failed == std::errc() && end == value.data() + value.size()) {
        const bool whole = value.find_first_not_of("-0123456789") == std::string::npos;
        parameter.type = whole ? ParameterType::integer : ParameterType::real;
        parameter.numbers = {number};
    } else {
        parameter.type = ParameterType::string;
        parameter.strings = {value};
    }
    return parameter;
}

Status set_pass_key(PassRequest& pass, const std::string& key, const std::string& value, const SourceLocation& where) {
    const auto refuse = [&](const char* expected) -> Status {
        return error_at(where, "'" + key + "=" + value + "' of a pass is not valid; expected " + expected);
    };
    const char* const end = value.data() + value.size();
    if (key == "spp") {
        std::int64_t samples = 0;
        const auto [at, failed] = std::from_chars(value.data(), end, samples);
        if (failed != std::errc() || at != end || samples < 1 || samples > most_pass_samples)
            return refuse("an integer of at least 1");
        pass.samples_per_pixel = static_cast<std::uint64_t>(samples);
    } else if (key == "share") {
        const auto [at, failed] = std::from_chars(value.data(), end, pass.time_share);
        if (failed != std::errc() || at != end || !(pass.time_share > 0 && pass.time_share <= 1e6))
            return refuse("a number above 0");
    } else if (key == "aovs") {
        if (value != "true" && value != "false") return refuse("true or false");
        pass.has_aovs = value == "true";
    } else if (key == "name") {
        pass.name = value;
        return check_layer_name(value, where);
    } else {
        pass.method.parameters.parameters.push_back(method_parameter(key, value, where));
    }
    return success();
}

}  // namespace

Result<PassRequest> parse_pass(const std::string& text, const SourceLocation& where) {
    PassRequest pass;
    pass.location = pass.method.location = pass.method.parameters.location = where;
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == text.size())
        return error_at(where, "'" + text +
                                   "' is not a pass; expected METHOD:EXPR, such as lighttracer:C<RD>S+[<L.>O], "
                                   "path:rest or path:rest:spp=64");
    pass.method.type = text.substr(0, colon);
    pass.takes = text.substr(colon + 1);
    for (std::set<std::string> keys;;) {
        const std::size_t last = pass.takes.rfind(':');
        if (last == std::string::npos || last == 0) break;
        const std::string item = pass.takes.substr(last + 1);
        const std::size_t equals = item.find('=');
        const bool is_of_label = item.find('\'') != std::string::npos;
        const std::string key = item.substr(0, equals);
        if (equals == std::string::npos || is_of_label || !is_key(key)) break;
        if (!keys.insert(key).second)
            return error_at(where, "the pass '" + text + "' has '" + key + "' twice; expected every key once");
        if (Status set = set_pass_key(pass, key, item.substr(equals + 1), where); !set) return set.error();
        pass.takes.resize(last);
    }
    return pass;
}

void read_passes(TomlTable& root, std::string_view key, std::vector<PassRequest>& passes) {
    const std::vector<const toml::table*> tables = root.take_tables(key);
    if (tables.empty() && root.take(key) != nullptr && !root.source().error())
        root.source().fail(error_at(root.location_of(key), "'" + std::string(key) + "' has no pass",
                                    "expected a table for each pass; without the key one method renders all paths"));
    for (const toml::table* table : tables) {
        TomlTable reader(root.source(), *table, "a [[" + std::string(key) + "]] table");
        PassRequest pass;
        bool whole = reader.require("method", pass.method.type);
        whole = reader.require("takes", pass.takes) && whole;
        pass.location = reader.content_location_of("takes");
        pass.method.location = reader.location_of("method");
        if (std::int64_t samples = 0; reader.read("spp", samples, 1, most_pass_samples))
            pass.samples_per_pixel = static_cast<std::uint64_t>(samples);
        if (const toml::node* share = reader.take("share"); share != nullptr) {
            pass.time_share = share->value<double>().value_or(0);
            if (!(pass.time_share > 0 && pass.time_share <= 1e6))
                reader.wrong_type("share", *share, "a number above 0");
        }
        reader.read("aovs", pass.has_aovs);
        if (reader.read("name", pass.name))
            if (Status fits = check_layer_name(pass.name, reader.location_of("name")); !fits)
                root.source().fail(fits.error());
        pass.method.parameters = reader.take_parameters();
        if (whole) passes.push_back(std::move(pass));
    }
}

}  // namespace raylex::experiments
