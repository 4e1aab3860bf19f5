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
    CLI::Option* add(const RenderSetting& setting) const {
        const RenderSetting::Values& values = setting.values;
        const std::string help = setting.text() + (values.is_repeated ? "; may be repeated" : "");
        if (setting.value.empty()) return command_.add_flag(setting.flag, help)->disable_flag_override()->group(name_);
        CLI::Option* option = command_.add_option(setting.flag, help)->option_text(setting.value)->group(name_);
        option->type_name("TEXT");
        if (values.type == RenderSetting::Type::boolean)
            option->check(CLI::IsMember(CLI::detail::split(setting.value, '|')));
        if (values.is_repeated) option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
        return values.has_commas ? option->delimiter(',') : option;
    }

  private:
    CLI::App& command_;
    std::string name_;
};

}  // namespace raylex::experiments
