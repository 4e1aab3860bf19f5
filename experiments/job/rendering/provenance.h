// The provenance of an image, for headers and statistics files.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

std::string raylex_version();     ///< "0.1.0"
std::string raylex_revision();    ///< git commit at build time, followed by "+changes" if files differed, or "unknown"
std::string build_description();  ///< compiler and build type
std::string host_description();   ///< processor model and hardware threads; no host name
std::string utc_time();           ///< "2024-03-01T12:00:00Z"

/// Returns the command line, quoted for a shell.
std::string shell_command(const std::vector<std::string>& arguments);

/// The settings of the integrator with which another render has the guide of a render with a time limit; empty without
/// a guide.
std::string guide_settings(const transport::GuideSummary& guide);

/// Returns a command line that renders one sample of an image: the original one with --replay and its instruction set.
std::string replay_command(const Job& job, const transport::RenderOutput& output,
                           const std::vector<std::string>& arguments, const display::InvalidSample& sample);
/// Returns a text about rejected samples: their number, the first one, and the command that renders it.
std::string text_of_invalid(const Job& job, const transport::RenderOutput& output,
                            const std::vector<std::string>& arguments);

/// Returns string attributes for the image header: version, revision, command, job text, scene, seed, samples, threads,
/// instruction set, integrator, sampler, filter, compiler, host, time, colour config.
std::map<std::string, std::string> header_attributes(const Job& job, const transport::RenderOutput& output,
                                                     const std::vector<std::string>& arguments,
                                                     const std::string& color_config);

}  // namespace raylex::experiments
