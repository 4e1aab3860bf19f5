// The table of the settings of a render: the one place for the flag, the job key, the Python name, the range, the
// default, the help and the setter of each. The command line, the reader of jobs, the arguments of raylex.render() and
// docs/rendering/settings.md are made from it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;

struct Setting {
    /// A whole number that is a multiple of `step`.
    struct Whole {
        std::uint64_t least = 0, most = 0, step = 1;
        std::function<void(Job&, std::uint64_t)> set;
    };
    struct Real {
        double least = 0, most = 0;
        std::function<void(Job&, double)> set;
    };
    /// One of `words`; set() gets its position.
    struct Choice {
        std::vector<std::string> words;
        std::function<void(Job&, std::size_t)> set;
    };
    /// true or false in a job. The flag has the words on and off or, without a value, sets what its name states.
    struct Switch {
        std::function<void(Job&, bool)> set;
    };
    struct Text {
        std::function<Status(Job&, const std::string&, const SourceLocation&)> set;
        bool is_path = false;  ///< in a job, relative to the job's folder
        /// Not empty: the form of the array that a job may have instead of the text. `separator` joins its numbers.
        std::string array{};
        std::string separator{};
    };
    struct Item {
        std::string text;
        SourceLocation location;
    };
    /// Several texts: a flag that may be repeated, and an array in a job.
    struct Texts {
        std::function<Status(Job&, const std::vector<Item>&)> set;
        bool has_commas = false;     ///< the flag takes several texts at once
        bool is_single_key = false;  ///< a job has one text instead of an array
        bool is_path = false;
    };
    /// Read by a function of its own.
    struct Own {
        bool is_repeated = false;
    };
    using Kind = std::variant<Whole, Real, Choice, Switch, Text, Texts, Own>;
    /// The kind, and the default as text; empty: unset.
    struct Values {
        Kind kind;
        std::string usual{};
    };
    enum class Use : std::uint8_t { often, rare };

    std::string flag;     ///< as CLI11 takes it: "-o,--output"; empty: none
    std::string key;      ///< TABLE.KEY in a job, or a KEY outside tables; empty: none
    std::string python;   ///< argument of raylex.render(); empty: none
    std::string value;    ///< placeholder of the flag's value in --help; empty: the flag has none
    Use use = Use::rare;  ///< `often`: --help shows the flag; otherwise only --help-all does
    std::string help;
    Values values{Own{}, {}};

    /// Returns the help, with the default.
    [[nodiscard]] std::string text() const;
};

struct SettingGroup {
    std::string heading;  ///< in --help
    std::vector<Setting> settings;
};

/// Returns all settings, in the order of --help and of their application.
const std::vector<SettingGroup>& setting_groups();
/// Returns the setting with this flag, which must exist.
const Setting& setting_of_flag(std::string_view flag);

/// Sets the setting from the values of its flag; an empty value counts as not given. Errors name the flag.
Status set_from_flag(const Setting& setting, const std::string& flag, const std::vector<std::string>& values, Job& job);

/// Reads the keys of the table `name` of a job, "render" for [render], with settings in the table. Paths are relative
/// to the folder of `job_path`.
void read_settings(TomlTable& table, std::string_view name, const std::string& job_path, Job& job);
/// Reads the KEY of a setting TABLE.KEY from any table.
void read_setting(TomlTable& table, std::string_view key, Job& job);

/// Returns docs/rendering/settings.md.
std::string settings_page();

// The rows, in setting_groups().
std::vector<Setting> file_settings();
std::vector<Setting> sampling_settings();
std::vector<Setting> image_settings();
std::vector<Setting> schedule_settings();
std::vector<Setting> machine_settings();
std::vector<Setting> method_settings();
std::vector<Setting> light_layer_settings();
std::vector<Setting> sample_layer_settings();
std::vector<Setting> color_settings();
std::vector<Setting> filter_settings();

}  // namespace raylex::experiments
