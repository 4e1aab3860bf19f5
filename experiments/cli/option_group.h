// A group of options under one heading in a command's --help.
#pragma once

#include <string>
#include <utility>

#include "experiments/cli/commands.h"
#include "experiments/job/settings/setting.h"

namespace raylex::experiments {

/// --help shows the groups in the order in which their first options were added.
class OptionGroup {
  public:
    OptionGroup(CLI::App& command, std::string name) : command_(command), name_(std::move(name)) {}

    /// Adds an option. `value` is the placeholder of its value in --help.
    template <typename T>
    CLI::Option* add(const std::string& names, T& to, const std::string& value, const std::string& description) const {
        return command_.add_option(names, to, description)->option_text(value)->group(name_);
    }
    /// Adds an option that can be repeated, with one value each time.
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
    /// Adds the flag of a setting, whose value Option::results() returns.
    CLI::Option* add(const Setting& setting) const {
        const std::string help = setting.text();
        const auto* texts = std::get_if<Setting::Texts>(&setting.values.kind);
        const auto* own = std::get_if<Setting::Own>(&setting.values.kind);
        if (setting.value.empty()) return command_.add_flag(setting.flag, help)->group(name_);
        const bool is_repeated = texts != nullptr || (own != nullptr && own->is_repeated);
        const std::string text = is_repeated ? help + "; may be repeated" : help;
        CLI::Option* option = command_.add_option(setting.flag, text)->option_text(setting.value)->group(name_);
        if (is_repeated) option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
        return texts != nullptr && texts->has_commas ? option->delimiter(',') : option;
    }

  private:
    CLI::App& command_;
    std::string name_;
};

}  // namespace raylex::experiments
