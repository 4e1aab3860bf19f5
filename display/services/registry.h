// The registry of materials, textures, lights, pixel filters, sample filters and integrators, for built-in objects and
// plugins.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/services/parameters.h"

namespace raylex {

/// Maps names to factories. `Factory` is a std::function or a function pointer that makes the object from its
/// parameters.
template <class Factory>
class Registry {
  public:
    struct Entry {
        std::string name;
        std::string help;  ///< one line for --help
        std::vector<ParameterDescription> parameters;
        Factory factory;
    };

    explicit Registry(std::string kind) : kind_(std::move(kind)) {}

    /// Registers `entry`; an earlier entry of that name is replaced, so plugins can override built-in objects.
    void add(Entry entry) {
        for (Entry& known : entries_)
            if (known.name == entry.name) {
                known = std::move(entry);
                return;
            }
        entries_.push_back(std::move(entry));
    }
    [[nodiscard]] const Entry* find(std::string_view name) const {
        for (const Entry& entry : entries_)
            if (entry.name == name) return &entry;
        return nullptr;
    }
    /// The entry; or an error at `where` that lists the known names and suggests a similar one.
    [[nodiscard]] Result<const Entry*> require(std::string_view name, const SourceLocation& where) const {
        if (const Entry* entry = find(name)) return entry;
        std::string known;
        for (const std::string& each : names()) known += (known.empty() ? "" : ", ") + each;
        return error_at(where, "unknown " + kind_ + " '" + std::string(name) + "'; expected one of: " + known,
                        near_miss(name, names()));
    }
    [[nodiscard]] std::vector<std::string> names() const {
        std::vector<std::string> result;
        for (const Entry& entry : entries_) result.push_back(entry.name);
        return result;
    }
    [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
    [[nodiscard]] const std::string& kind() const { return kind_; }

  private:
    std::string kind_;
    std::vector<Entry> entries_;
};

}  // namespace raylex
