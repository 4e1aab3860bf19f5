// The table of the settings of a render: the one place for the flag, the job key, the Python name, the range, the
// default, the help and the setter of each. The command line, the reader of jobs, the arguments of raylex.render() and
// docs/rendering/settings.md are made from it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;

struct RenderSetting {
    enum class Use : std::uint8_t { often, rare };
    enum class Type : std::uint8_t { integer, number, boolean, string, strings, own };
    struct Item {
        std::string text;
        SourceLocation location;
    };
    struct Values {
        Type type = Type::own;    ///< in a job; `own`: a function of its own reads it
        std::string range{};      ///< what a value can be; empty: RenderSetting::value states it
        std::string usual{};      ///< the default; empty: unset
        std::string separator{};  ///< not empty: a job may have an array of integers, which it joins to the flag's text
        bool is_path = false;     ///< in a job, relative to the job's folder
        bool is_repeated = false;  ///< the flag can be given several times
        bool has_commas = false;   ///< the flag takes several values at once
        bool has_empty = false;    ///< the empty text is a value; otherwise a flag with it counts as not given
        /// Sets the values of a job. A text is as in a flag; a boolean is "true" or "false".
        std::function<Status(Job&, const std::vector<Item>&)> set{};
    };
    std::string flag;    ///< as CLI11 takes it: "-o,--output"; empty: none
    std::string key;     ///< TABLE.KEY in a job, or a KEY outside tables; empty: none
    std::string python;  ///< argument of raylex.render(); empty: none
    std::string value;   ///< placeholder of the flag's value in --help; empty: the flag has none
    Use use;             ///< `often`: --help shows the flag; otherwise only --help-all does
    std::string help;
    Values values{};

    /// Returns the help, with the default.
    [[nodiscard]] std::string text() const;
};

/// The settings under one heading of --help.
struct SettingGroup {
    std::string heading;
    std::vector<RenderSetting> settings;
};

/// Returns all settings, in the order of --help and of their application.
const std::vector<SettingGroup>& setting_groups();
/// Returns the setting with this flag, which must exist.
const RenderSetting& setting_of_flag(std::string_view flag);

/// Sets the setting from the values of its flag; an empty value counts as not given. Errors name the flag.
Status set_from_flag(const RenderSetting& setting, const std::string& flag, const std::vector<std::string>& values,
                     Job& job);

/// Reads the keys of the table `name` of a job, "render" for [render], with settings in the table. Paths are relative
/// to the folder of `job_path`.
void read_settings(TomlTable& table, std::string_view name, const std::string& job_path, Job& job);
/// Reads the table [name] of a job, if there is one, and what `read_more` reads from it besides settings. Any other key
/// is an error. Returns the location of the table.
SourceLocation read_settings_table(TomlTable& root, const std::string& name, const std::string& job_path, Job& job,
                                   const std::function<void(TomlTable&)>& read_more = {});
/// Reads the KEY of a setting TABLE.KEY from any table.
void read_setting(TomlTable& table, std::string_view key, Job& job);

/// Returns docs/rendering/settings.md.
std::string settings_page();

// The rows, in setting_groups().
std::vector<RenderSetting> file_settings(), sampling_settings(), image_settings(), schedule_settings(),
    machine_settings(), method_settings(), light_layer_settings(), sample_layer_settings(), color_settings(),
    filter_settings();

}  // namespace raylex::experiments
