// The arithmetic of a colour grade, shared by the sample filter and the display filter of that name.
#pragma once

#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "display/services/rgb.h"

namespace raylex::display {

/// value x 2^exposure x gain + offset; then each component to the power 1 / gamma (its sign kept); then each
/// component's distance from the luminance (weights of Rec. 709) times `saturation`.
struct Grade {
    RgbD gain{1.0};  ///< with the exposure in it
    RgbD offset{0.0}, gamma{1.0};
    double saturation = 1;

    /// Without offset and gamma a grade of a sum is the sum of the grades.
    [[nodiscard]] bool is_linear() const { return offset == RgbD(0.0) && gamma == RgbD(1.0); }
    [[nodiscard]] RgbD apply(const RgbD& value) const;
    /// To a colour's three components, in place; or to a single number, which has no saturation, by the first
    /// components.
    void apply(double* values, int components) const;
};

/// Parameters of a grade, for registries: exposure, gain, offset, gamma, saturation and channels.
std::vector<ParameterDescription> grade_parameters();

/// Errors at the set's location: a value that is not finite, a negative gain or saturation, a gamma that is not
/// positive. `who` is how errors call the filter.
Result<Grade> read_grade(const ParameterSet& parameters, const std::string& who);

/// One number for all three components, or three of them.
Result<RgbD> read_triple(const ParameterSet& parameters, const std::string& name, double fallback,
                         const std::string& who);

/// Names from a parameter that is a list of strings, or one string with commas or blanks between the names.
std::vector<std::string> read_names(const ParameterSet& parameters, const std::string& name);

/// The ids of channels by name. Errors at the set's location: no such channel (with the near miss), one that samples
/// cannot be sent to, an integer. `beauty` may be called "beauty" whatever its name.
Result<std::vector<ChannelId>> named_channels(const std::vector<std::string>& names,
                                              const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                              const ParameterSet& parameters, const std::string& who);

/// Beauty, if there is one, and every expression channel that holds light: not those with nothruput or overwrite.
Result<std::vector<ChannelId>> light_channels(const std::vector<ChannelDefinition>& channels, ChannelId beauty);

/// What a grade changes: the channels it names, or all light when it names none; then it must be linear.
Result<std::vector<ChannelId>> graded_channels(const Grade& grade, const ParameterSet& parameters,
                                               const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                               const std::string& who);

}  // namespace raylex::display
