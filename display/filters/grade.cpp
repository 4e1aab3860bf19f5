#include "display/filters/grade.h"

#include <algorithm>
#include <cmath>

#include "display/services/channel_prefixes.h"
#include "display/services/elementary.h"

namespace raylex::display {
namespace {

double power(double value, double gamma) {
    return gamma == 1 ? value : std::copysign(elementary::pow(std::abs(value), 1 / gamma), value);
}

}  // namespace

RgbD Grade::apply(const RgbD& value) const {
    RgbD result = value * gain + offset;
    for (int c = 0; c < 3; ++c) result[c] = power(result[c], gamma[c]);
    if (saturation == 1) return result;
    const RgbD grey(luminance(result));
    return grey + (result - grey) * saturation;
}

void Grade::apply(double* values, int components) const {
    if (components == 3) {
        const RgbD result = apply(RgbD(values[0], values[1], values[2]));
        for (int c = 0; c < 3; ++c) values[c] = result[c];
    } else {
        values[0] = power(values[0] * gain.r + offset.r, gamma.r);
    }
}

std::vector<ParameterDescription> grade_parameters() {
    return {{"exposure", ParameterType::real, "0", "exposure in stops; each doubles the light"},
            {"gain", ParameterType::rgb, "1", "one factor or three, >= 0"},
            {"offset", ParameterType::rgb, "0", "one summand or three, added after gain; only with channels"},
            {"gamma", ParameterType::rgb, "1",
             "one gamma or three, > 0; the value becomes value^(1 / gamma); only with channels"},
            {"saturation", ParameterType::real, "1", "0 is grey, 1 keeps colours, above 1 increases saturation, >= 0"},
            {"channels", ParameterType::string, "",
             "names of the channels to change; none: beauty and all light layers alike, so that splits still sum"}};
}

Result<RgbD> read_triple(const ParameterSet& parameters, const std::string& name, double fallback,
                         const std::string& who) {
    const Parameter* parameter = parameters.find(name);
    if (parameter == nullptr) return RgbD(fallback);
    const std::vector<double>& numbers = parameter->numbers;
    const bool fits = (numbers.size() == 1 || numbers.size() == 3) &&
                      std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); });
    if (!fits)
        return error_at(parameter->location, who + " has a parameter '" + name +
                                                 "' that is neither a number nor three numbers; expected, for example, "
                                                 "1.5 or three numbers for red, green and blue");
    return numbers.size() == 1 ? RgbD(numbers[0]) : RgbD(numbers[0], numbers[1], numbers[2]);
}

Result<Grade> read_grade(const ParameterSet& parameters, const std::string& who) {
    Grade grade;
    const auto exposure = parameters.real_or("exposure", 0);
    if (!exposure) return exposure.error();
    const auto saturation = parameters.real_or("saturation", 1);
    if (!saturation) return saturation.error();
    const auto gain = read_triple(parameters, "gain", 1, who);
    if (!gain) return gain.error();
    const auto offset = read_triple(parameters, "offset", 0, who);
    if (!offset) return offset.error();
    const auto gamma = read_triple(parameters, "gamma", 1, who);
    if (!gamma) return gamma.error();
    const auto wrong = [&](const char* text) { return error_at(parameters.location, who + " has " + text); };
    if (!(std::abs(*exposure) <= 64)) return wrong("an exposure beyond 64 stops; expected one from -64 to 64");
    if (!(std::min({gain->r, gain->g, gain->b}) >= 0)) return wrong("a negative gain; expected 0 or above");
    if (!(std::min({gamma->r, gamma->g, gamma->b}) > 0))
        return wrong("a gamma that is not above 0; expected, for example, 2.2");
    if (!(*saturation >= 0) || !std::isfinite(*saturation)) return wrong("a negative saturation; expected 0 or above");
    grade.gain = *gain * elementary::exp2(*exposure);
    grade.offset = *offset;
    grade.gamma = *gamma;
    grade.saturation = *saturation;
    return grade;
}

std::vector<std::string> read_names(const ParameterSet& parameters, const std::string& name) {
    std::vector<std::string> names;
    const Parameter* parameter = parameters.find(name);
    if (parameter == nullptr) return names;
    for (const std::string& text : parameter->strings) {
        std::string word;
        for (const char c : text + ",") {
            if (c != ',' && c != ' ') {
                word += c;
            } else if (!word.empty()) {
                names.push_back(word);
                word.clear();
            }
        }
    }
    return names;
}

Result<std::vector<ChannelId>> named_channels(const std::vector<std::string>& names,
                                              const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                              const ParameterSet& parameters, const std::string& who) {
    std::vector<ChannelId> ids;
    for (const std::string& name : names) {
        ChannelId found = name == "beauty" ? beauty : invalid_channel;
        std::vector<std::string> known;
        std::string list;
        for (std::size_t i = 0; i < channels.size(); ++i) {
            if (!takes_samples(channels[i]) || channels[i].type == ChannelType::integer) continue;
            if (channels[i].name == name) found = static_cast<ChannelId>(i);
            known.push_back(channels[i].name);
            list += (list.empty() ? "" : ", ") + known.back();
        }
        if (found < 0) {
            return error_at(parameters.location,
                            who + " names the channel '" + name +
                                "', which does not exist or has no filterable numbers; "
                                "expected one of: " +
                                list,
                            near_miss(name, known));
        }
        if (std::find(ids.begin(), ids.end(), found) == ids.end()) ids.push_back(found);
    }
    return ids;
}

Result<std::vector<ChannelId>> light_channels(const std::vector<ChannelDefinition>& channels, ChannelId beauty) {
    std::vector<ChannelId> ids;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const auto id = static_cast<ChannelId>(i);
        if (channels[i].style != ChannelStyle::expression && id != beauty) continue;
        if (id != beauty) {
            const auto prefixes = read_prefixes(channels[i]);
            if (!prefixes) return prefixes.error();
            if (prefixes->nothruput || prefixes->overwrite) continue;
        }
        ids.push_back(id);
    }
    return ids;
}

Result<std::vector<ChannelId>> graded_channels(const Grade& grade, const ParameterSet& parameters,
                                               const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                               const std::string& who) {
    const std::vector<std::string> names = read_names(parameters, "channels");
    if (!names.empty()) return named_channels(names, channels, beauty, parameters, who);
    if (!grade.is_linear())
        return error_at(parameters.location,
                        who +
                            " has an offset or a gamma, with which layers no longer sum to the beauty; expected the "
                            "channels it is for, such as channels=beauty, or exposure, gain and saturation alone");
    return light_channels(channels, beauty);
}

}  // namespace raylex::display
