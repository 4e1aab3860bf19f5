// The arithmetic of a colour grade, which the sample filter and the display filter "grade" share.
#pragma once

#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/parameters.h"
#include "display/services/rgb.h"

namespace raylex::display {

/// Computes value x 2^exposure x gain + offset; then raises each component to the power 1 / gamma (keeping its sign);
/// then scales each component's distance from the luminance (weights of Rec. 709) by `saturation`.
struct Grade {
    RgbD gain{1.0};  ///< includes the exposure
    RgbD offset{0.0}, gamma{1.0};
    double saturation = 1;

    /// Without offset and gamma, the grade of a sum is the sum of the grades.
    [[nodiscard]] bool is_linear() const { return offset == RgbD(0.0) && gamma == RgbD(1.0); }
    [[nodiscard]] RgbD apply(const RgbD& value) const;
    /// Grades a colour's three components in place; or a single number, with the first components and without
    /// saturation.
    void apply(double* values, int components) const;
};

/// The parameters of a grade for registries: exposure, gain, offset, gamma, saturation and channels.
std::vector<ParameterDescription> grade_parameters();

/// Reads a grade. Errors, at the set's location: a value that is not finite, a negative gain or saturation, a gamma
/// that is not positive. `who` is the name of the filter in errors.
Result<Grade> read_grade(const ParameterSet& parameters, const std::string& who);

/// Reads one number for all three components, or three numbers.
Result<RgbD> read_triple(const ParameterSet& parameters, const std::string& name, double fallback,
                         const std::string& who);

/// Reads names from a list of strings, or from one string with commas or blanks between the names.
std::vector<std::string> read_names(const ParameterSet& parameters, const std::string& name);

/// The ids of channels by name. Errors, at the set's location: no such channel (with a similar name), a channel that
/// takes no samples, an integer channel. "beauty" always refers to the channel `beauty`.
Result<std::vector<ChannelId>> named_channels(const std::vector<std::string>& names,
                                              const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                              const ParameterSet& parameters, const std::string& who);

/// Beauty, if there is one, and every expression channel that contains light, that is, without nothruput and overwrite.
Result<std::vector<ChannelId>> light_channels(const std::vector<ChannelDefinition>& channels, ChannelId beauty);

/// The channels that a grade changes: the named ones, or all light if none is named; the grade must then be linear.
Result<std::vector<ChannelId>> graded_channels(const Grade& grade, const ParameterSet& parameters,
                                               const std::vector<ChannelDefinition>& channels, ChannelId beauty,
                                               const std::string& who);

}  // namespace raylex::display
