// Strict reading of TOML tables. An unknown key is an error with the closest match, every value must have its type, and
// every error names file, line and column. The first error in the order of the text is reported.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/parameters.h"
#include "lpe/language/source_map.h"
#include "lpe/result.h"

// Uses the compiled libtomlplusplus to keep this header cheap.
#include <toml++/toml.h>

namespace raylex::experiments {

/// The source text of a job and the first error in it.
class TomlSource {
  public:
    TomlSource(std::string file, std::string_view text);

    /// Returns a source position. Converts columns from toml++'s characters to bytes, which Error uses.
    [[nodiscard]] SourceLocation location(const toml::source_region& region) const;
    [[nodiscard]] SourceLocation location(const toml::node& node) const { return location(node.source()); }
    /// Returns the position of the first character of a string value, after its opening quotes.
    [[nodiscard]] SourceLocation content_location(const toml::node& node) const;

    /// Returns the source position of each byte of a string value, with escapes resolved; null if the text cannot be
    /// followed.
    [[nodiscard]] std::shared_ptr<const lpe::SourceMap> string_map(const toml::node& node) const;

    void fail(const SourceLocation& where, std::string message, std::string hint = {});
    void fail(Error error);  ///< records an error about this text and adds its excerpt
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  private:
    std::string file_;
    std::shared_ptr<const lpe::TextFile> text_;
    std::vector<std::string> lines_;
    std::optional<Error> error_;
};

/// A table of the text. A look-up marks its key as known; close() reports all other keys.
class TomlTable {
  public:
    /// `description` names the table in errors: "[render]", "a [[label]] table".
    TomlTable(TomlSource& source, const toml::table& table, std::string description);

    /// Each read() returns whether the key exists with the right type, and changes `value` only then.
    bool read(std::string_view key, std::string& value);
    bool read(std::string_view key, bool& value);
    bool read(std::string_view key, std::int64_t& value, std::int64_t least, std::int64_t most);
    bool read(std::string_view key, std::vector<std::string>& value, std::vector<SourceLocation>* locations = nullptr);
    /// Reads a string that must exist and must not be empty.
    bool require(std::string_view key, std::string& value);

    /// Returns the node of the key with any type, or null.
    const toml::node* take(std::string_view key);
    const toml::table* take_table(std::string_view key);
    /// Returns the tables of `[[key]]`. Any other value is an error.
    std::vector<const toml::table*> take_tables(std::string_view key);

    [[nodiscard]] SourceLocation location() const { return source_.location(table_); }
    [[nodiscard]] SourceLocation location_of(std::string_view key) const;
    [[nodiscard]] SourceLocation content_location_of(std::string_view key) const;
    [[nodiscard]] std::shared_ptr<const lpe::SourceMap> string_map_of(std::string_view key) const;
    [[nodiscard]] bool has(std::string_view key) const { return table_.get(key) != nullptr; }
    [[nodiscard]] TomlSource& source() { return source_; }
    [[nodiscard]] const std::string& description() const { return description_; }

    /// Returns all keys that were not read as parameters, for an integrator, a sampler or a filter.
    ParameterSet take_parameters();
    /// Reports a value of another type than `expected`, such as "an integer".
    void wrong_type(std::string_view key, const toml::node& node, const char* expected);
    /// Reports an error for the first key that was not read.
    void close();

  private:
    TomlSource& source_;
    const toml::table& table_;
    std::string description_;
    std::vector<std::string> known_;
};

}  // namespace raylex::experiments
