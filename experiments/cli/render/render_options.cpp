#include "experiments/cli/render/render_options.h"

#include <algorithm>

#include "experiments/cli/option_group.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/job/settings/setting.h"
#include "experiments/report/png_driver.h"

namespace raylex::experiments {
namespace {

/// Returns the name of a flag in messages: "--output".
std::string long_name(const RenderSetting& setting) {
    return setting.flag.substr(std::min(setting.flag.find("--"), setting.flag.size()));
}

/// --help shows the options that people use most, --help-all shows every option.
bool is_often_used(const CLI::Option& option) {
    if (option.check_lname("help") || option.check_lname("help-all")) return true;
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings)
            if (setting.use == RenderSetting::Use::often && option.check_name(long_name(setting))) return true;
    return false;
}

class ShortHelp final : public CLI::Formatter {
  public:
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
        if (mode == CLI::AppFormatMode::All) return Formatter().make_help(app, name, mode);
        return Formatter::make_help(app, name, mode) + "'raylex render --help-all' lists all options.\n";
    }
    std::string make_group(std::string group, bool positional, std::vector<const CLI::Option*> options) const override {
        if (!positional) std::erase_if(options, [](const CLI::Option* option) { return !is_often_used(*option); });
        return options.empty() ? std::string() : Formatter::make_group(group, positional, options);
    }
};

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
    register_png_driver();  // --driver lists it
    command.formatter(std::make_shared<ShortHelp>());
    command.set_help_all_flag("--help-all", "Print all options and exit");
    command.add_option("SCENE.pbrt|JOB.toml", options.input, "a pbrt-v4 scene, or a TOML job that names one")
        ->required()
        ->option_text("(required)");
    for (const SettingGroup& settings : setting_groups()) {
        const OptionGroup group(command, settings.heading);
        for (const RenderSetting& setting : settings.settings) {
            if (setting.flag == "--plugin") add_plugin_option(command, options.plugins)->group(settings.heading);
            else if (!setting.flag.empty()) group.add(setting);
        }
        if (settings.heading == "Long renders") add_command_output_options(command, options.commands, settings.heading);
    }
}

Status apply_flags(const CLI::App& command, Job& job) {
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings) {
            const std::string flag = long_name(setting);
            if (flag.empty() || command.count(flag) == 0) continue;
            if (Status set = set_from_flag(setting, flag, command.get_option(flag)->results(), job); !set) return set;
            const std::string file = flag.starts_with("--deep-") ? job.outputs.deep.file : job.outputs.atlas.file;
            const bool needs_file = flag.starts_with("--deep-") || flag.starts_with("--atlas-");
            if (needs_file && file.empty())
                return error_at({flag, 0, 0}, "this setting has no file to apply to; expected " +
                                                  flag.substr(0, flag.find('-', 2)) + " FILE.exr as well");
        }
    return success();
}

}  // namespace raylex::experiments
