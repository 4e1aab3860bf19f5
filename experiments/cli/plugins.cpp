// raylex plugins: lists the types that plugins add, or the built-in ones. Also --plugin, for commands that read scenes.
#include <memory>
#include <utility>

#include "display/services/channel_settings.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/job/job_tables.h"
#include "experiments/job/settings/setting.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/report/png_driver.h"
#include "transport/cameras/camera.h"
#include "transport/media/medium.h"
#include "transport/plugins/plugin_loader.h"
#include "transport/scene/sampler.h"
#include "transport/textures/pattern.h"

namespace raylex::experiments {
namespace {

using transport::PluginEntry;

void print_entry(const PluginEntry& entry) {
    print_line("  " + entry.kind + " " + entry.name + (entry.shadows ? " (instead of the in-tree one)" : "") + ": " +
               entry.help);
    for (const ParameterDescription& each : entry.parameters)
        print_line("      " + std::string(type_name(each.type)) + " " + each.name +
                   (each.fallback.empty() ? "" : " = " + each.fallback) + ": " + each.help);
}

template <class Factory>
void print_registry(const Registry<Factory>& registry) {
    for (const auto& entry : registry.entries())
        print_entry({registry.kind(), entry.name, entry.help, entry.parameters, false});
}

void print_in_tree() {
    register_png_driver();
    print_line("in the program:");
    print_registry(transport::integrator_registry());
    print_registry(transport::camera_registry());
    print_registry(transport::sampler_registry());
    print_registry(transport::material_registry());
    print_registry(transport::pattern_registry());
    print_registry(transport::medium_registry());
    print_registry(transport::shape_registry());
    print_registry(transport::light_registry());
    print_registry(transport::area_light_registry());
    print_registry(display::pixel_filter_registry());
    print_registry(display::sample_filter_registry());
    print_registry(display::display_filter_registry());
    print_registry(display::display_driver_registry());
    print_registry(display::channel_registry());
}

int list_plugins(const std::vector<std::string>& files) {
    if (files.empty()) print_in_tree();
    for (const std::string& file : files) {
        if (Status loaded = transport::load_plugin(file, {}); !loaded) return report_error(loaded.error());
        for (const transport::LoadedPlugin& plugin : transport::loaded_plugins()) {
            if (plugin.file != file) continue;
            print_line(file + ":");
            for (const PluginEntry& entry : plugin.entries) print_entry(entry);
        }
    }
    return exit_holds;
}

}  // namespace

CLI::Option* add_plugin_option(CLI::App& command, std::vector<std::string>& files) {
    const RenderSetting& setting = setting_of_flag("--plugin");
    return command.add_option(setting.flag, files, setting.help + "; may be repeated")
        ->option_text(setting.value)
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

Status load_plugins(const std::vector<std::string>& files) {
    for (const std::string& file : files)
        if (Status loaded =
                transport::load_plugin(is_shipped_plugin(file) ? shipped_plugin(file) : file, {"--plugin", 0, 0});
            !loaded)
            return loaded;
    return success();
}

void add_plugins_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "plugins", "Lists the types that plugins add, with all parameters; without arguments, the built-in types.");
    auto files = std::make_shared<std::vector<std::string>>();
    command->add_option("FILE.so", *files, "plugins to load")->option_text("...");
    command->footer("An incompatible plugin is refused with an error that names the difference; the exit code is 2.");
    command->callback([files, &context] { context.exit_code = list_plugins(*files); });
}

}  // namespace raylex::experiments
