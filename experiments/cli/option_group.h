// Options of a command that its --help shows together.
#pragma once

#include <string>
#include <utility>

#include "experiments/cli/commands.h"

namespace raylex::experiments {

/// Groups stand in --help in the order of their first options.
class OptionGroup {
  public:
    OptionGroup(CLI::App& command, std::string name) : command_(command), name_(std::move(name)) {}

    /// `value` is how its value reads in --help.
    template <typename T>
    CLI::Option* add(const std::string& names, T& to, const std::string& value, const std::string& description) const {
        return command_.add_option(names, to, description)->option_text(value)->group(name_);
    }
    /// One that may stand several times, each with one value.
    template <typename T>
    CLI::Option* add_repeated(const std::string& names, T& to, const std::string& value,
                              const std::string& description) const {
        return add(names, to, value, description + "; may be repeated")
            ->expected(1)
            ->allow_extra_args(false)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    }
    CLI::Option* add_flag(const std::string& names, bool& to, const std::string& description) const {
        return command_.add_flag(names, to, description)->group(name_);
    }

  private:
    CLI::App& command_;
    std::string name_;
};

}  // namespace raylex::experiments
