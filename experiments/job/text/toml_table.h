// Strict reading of TOML tables: every key is known or refused with its near miss, every value has the type it must
// have, every error names file, line and column. The first error in the order of the text wins.
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

// The compiled libtomlplusplus is used, so that this header stays cheap.
#include <toml++/toml.h>

namespace raylex::experiments {

/// The text a job came from and the earliest error found in it.
class TomlSource {
  public:
    TomlSource(std::string file, std::string_view text);

    /// toml++ counts columns in characters, Error in bytes: this converts.
    [[nodiscard]] SourceLocation location(const toml::source_region& region) const;
    [[nodiscard]] SourceLocation location(const toml::node& node) const { return location(node.source()); }
    /// Where the characters of a string value begin: after its opening quotes.
    [[nodiscard]] SourceLocation content_location(const toml::node& node) const;

    /// Where each byte of a string value stands, its escapes resolved; null when the text cannot be followed.
    [[nodiscard]] std::shared_ptr<const lpe::SourceMap> string_map(const toml::node& node) const;

    void fail(const SourceLocation& where, std::string message, std::string hint = {});
    void fail(Error error);  ///< an error made elsewhere, about this text; gets its excerpt here
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  private:
    std::string file_;
    std::shared_ptr<const lpe::TextFile> text_;
    std::vector<std::string> lines_;
    std::optional<Error> error_;
};

/// One table. A look-up marks its key as known; close() refuses the rest.
class TomlTable {
  public:
    /// `description` is how errors call the table: "[render]", "a [[label]] table".
    TomlTable(TomlSource& source, const toml::table& table, std::string description);

    /// Each returns whether the key was there with the right type; `value` is changed only then.
    bool read(std::string_view key, std::string& value);
    bool read(std::string_view key, bool& value);
    bool read(std::string_view key, std::int64_t& value, std::int64_t least, std::int64_t most);
    bool read(std::string_view key, std::vector<std::string>& value, std::vector<SourceLocation>* locations = nullptr);
    /// A string that must be there and must not be empty.
    bool require(std::string_view key, std::string& value);

    /// The key's node, or null; any type.
    const toml::node* take(std::string_view key);
    const toml::table* take_table(std::string_view key);
    /// The tables of `[[key]]`; an error when it is anything else.
    std::vector<const toml::table*> take_tables(std::string_view key);

    [[nodiscard]] SourceLocation location() const { return source_.location(table_); }
    [[nodiscard]] SourceLocation location_of(std::string_view key) const;
    [[nodiscard]] SourceLocation content_location_of(std::string_view key) const;
    [[nodiscard]] std::shared_ptr<const lpe::SourceMap> string_map_of(std::string_view key) const;
    [[nodiscard]] bool has(std::string_view key) const { return table_.get(key) != nullptr; }
    [[nodiscard]] TomlSource& source() { return source_; }
    [[nodiscard]] const std::string& description() const { return description_; }

    /// Every key that was not read, turned into parameters: what an integrator, a sampler or a filter takes.
    ParameterSet take_parameters();
    /// An error for the first key that nobody asked for.
    void close();

  private:
    void wrong_type(std::string_view key, const toml::node& node, const char* expected);

    TomlSource& source_;
    const toml::table& table_;
    std::string description_;
    std::vector<std::string> known_;
};

}  // namespace raylex::experiments
