// --scene: makes proofs relative to the paths that one scene can produce.
#include "experiments/cli/lpe/commands.h"
#include "experiments/cli/plugin_options.h"
#include "experiments/job/channels/channel_reasons.h"
#include "experiments/program/console.h"

namespace raylex::experiments {

Result<std::optional<ScenePathStrings>> SceneOption::load() const {
    if (path.empty()) return std::optional<ScenePathStrings>();
    if (Status loaded = load_plugins(plugins); !loaded) return loaded.error();
    auto words = read_scene_path_strings(path);
    if (!words) return words.error();
    return std::optional(std::move(*words));
}

CLI::Option* add_scene_option(CLI::App& command, SceneOption& scene) {
    add_plugin_option(command, scene.plugins);
    return command
        .add_option("--scene", scene.path,
                    "considers only paths that this scene can produce with its labels, lobes, lights, media and depth, "
                    "under the settings of the job")
        ->option_text("SCENE.pbrt|JOB.toml");
}

lpe::PathStrings path_strings_of(const std::optional<ScenePathStrings>& scene) {
    return scene ? scene->words : lpe::PathStrings{};
}

void warn_about_scene(std::span<const lpe::ChannelSource> channels, const std::optional<ScenePathStrings>& scene) {
    if (!scene) return;
    for (const lpe::ChannelSource& channel : channels) {
        if (!channel.rest_of.empty()) continue;
        const std::string who = channel.name.empty() ? "the expression" : "channel '" + channel.name + "'";
        const auto never = why_never(channel, *scene);
        if (never && *never) {
            print_warning(who + " matches no path of this scene: " + **never);
            continue;
        }
        const auto unknown = unknown_labels(channel, *scene);
        if (!unknown) continue;
        for (const std::string& each : *unknown) print_warning(who + ": " + each);
    }
}

}  // namespace raylex::experiments
