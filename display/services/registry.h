// The one door through which every material, texture, light, pixel filter, sample filter and integrator comes in,
// in-tree ones and plugins alike.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/services/parameters.h"

namespace raylex {

/// Names to factories. `Factory` is a std::function or a function pointer that builds the object from its parameters.
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

    /// Registers `entry`; a name registered before is replaced (a plugin may shadow an in-tree object).
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
    /// The entry, or an error at `where` that lists what there is and the near miss.
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
