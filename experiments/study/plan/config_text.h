// The text of an experiment's config as TOML tables, with values of the command line and of sweeps inserted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "experiments/study/plan/axis.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Parses the text again for every variant, because toml++ nodes lose their source position when copied.
class ConfigText {
  public:
    /// `overrides` are the KEY=VALUE of --set. KEY is a path such as replicates, reference.spp, method.NAME.max_depth
    /// or scene.*.resolution (NAME selects a table of a list, * all of them). VALUE is TOML, or else a plain word.
    ConfigText(std::string file, std::string text, std::vector<std::string> overrides);

    /// Returns the whole config with overrides. Errors: invalid TOML (with its place), an unknown KEY.
    Result<toml::table> parse() const;
    /// Puts a value under a dotted key of a table, and makes tables as necessary. A plain word on the way, such as
    /// integrator = "path" before integrator.strategy, becomes the type of the new table.
    static void put(toml::table& table, const std::string& key, const AxisValue& value);

    /// Returns the source text, for errors of later readers.
    [[nodiscard]] TomlSource source() const { return {file_, text_}; }
    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] const std::string& text() const { return text_; }
    [[nodiscard]] const std::vector<std::string>& overrides() const { return overrides_; }

  private:
    Status apply(const std::string& override, toml::table& root) const;
    std::string file_, text_;
    std::vector<std::string> overrides_;
};

/// Returns the table of [[KEY]] with this name; null if there is none.
toml::table* named_table(toml::table& root, std::string_view key, std::string_view name);

}  // namespace raylex::experiments
