#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {
namespace {

constexpr std::size_t most_lines = 10'000;

void put(const std::string& name, const AxisValue& value, const SourceLocation& where, Setting& setting) {
    if (const auto* text = std::get_if<std::string>(&value.value)) {
        const auto number = evaluate(*text, setting.numbers, where);
        if (number) setting.numbers[name] = *number;
        else setting.words[name] = *text;
    } else if (const auto* flag = std::get_if<bool>(&value.value)) {
        setting.words[name] = *flag ? "true" : "false";
    } else if (const auto* whole = std::get_if<std::int64_t>(&value.value)) {
        setting.numbers[name] = static_cast<double>(*whole);
    } else {
        setting.numbers[name] = std::get<double>(value.value);
    }
}

}  // namespace

Result<std::vector<Setting>> StabilityCase::settings(bool only_fast) const {
    std::vector<const CaseAxis*> axes;
    for (const CaseAxis& axis : varied) axes.push_back(&axis);
    if (only_fast)
        for (const CaseAxis& kept : fast)
            for (const CaseAxis*& axis : axes)
                if (axis->name == kept.name) axis = &kept;
    std::size_t lines = 1;
    for (const CaseAxis* axis : axes) {
        lines *= axis->values.size();
        if (lines > most_lines) return error_at(axis->location, "'" + name + "' has more than 10000 lines");
    }
    std::vector<Setting> result;
    for (std::size_t line = 0; line < lines; ++line) {
        Setting setting;
        std::vector<const AxisValue*> values(axes.size());
        for (std::size_t i = axes.size(), rest = line; i-- > 0; rest /= axes[i]->values.size())
            values[i] = &axes[i]->values[rest % axes[i]->values.size()];
        for (std::size_t i = 0; i < axes.size(); ++i) {
            put(axes[i]->name, *values[i], axes[i]->location, setting);
            setting.text += (setting.text.empty() ? "" : ", ") + axes[i]->name + " = " + values[i]->text();
        }
        for (const CaseAxis& axis : constants) put(axis.name, axis.values.front(), axis.location, setting);
        result.push_back(std::move(setting));
    }
    return result;
}

}  // namespace raylex::experiments
