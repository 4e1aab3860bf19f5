// The text of an experiment's config as TOML tables, with values of the command line and of sweeps put in.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "experiments/study/plan/axis.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Parsed anew for every variant: nodes of toml++ know where they stand only as long as they are not copied.
class ConfigText {
  public:
    /// `overrides` are KEY=VALUE of --set: KEY is a path such as replicates, reference.spp, method.NAME.max_depth or
    /// scene.*.resolution (tables of a list go by their names; * is all of them); VALUE is TOML, or else a plain word.
    ConfigText(std::string file, std::string text, std::vector<std::string> overrides);

    /// The whole config, overrides applied. Errors: no valid TOML (with its place), a KEY that leads nowhere.
    Result<toml::table> parse() const;
    /// Puts a value under a dotted key of a table, making tables on the way. Where there is a plain word already, such
    /// as integrator = "path" before integrator.strategy, it becomes that table's type.
    static void put(toml::table& table, const std::string& key, const AxisValue& value);

    /// For the errors of all that reads it.
    [[nodiscard]] TomlSource source() const { return {file_, text_}; }
    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] const std::string& text() const { return text_; }
    [[nodiscard]] const std::vector<std::string>& overrides() const { return overrides_; }

  private:
    Status apply(const std::string& override, toml::table& root) const;
    std::string file_, text_;
    std::vector<std::string> overrides_;
};

/// The one of [[KEY]] with this name; null when there is none.
toml::table* named_table(toml::table& root, std::string_view key, std::string_view name);

}  // namespace raylex::experiments
