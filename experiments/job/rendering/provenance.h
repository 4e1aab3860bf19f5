// Where an image came from: what goes into every header and every statistics file.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "transport/render/render.h"

namespace raylex::experiments {

std::string raylex_version();     ///< "0.1.0"
std::string raylex_revision();    ///< git commit at build time, "+changes" after it when files differed, or "unknown"
std::string build_description();  ///< compiler and build type
std::string host_description();   ///< processor model and hardware threads; no host name
std::string utc_time();           ///< "2024-03-01T12:00:00Z"

/// The command line as a shell would take it.
std::string shell_command(const std::vector<std::string>& arguments);

/// The command line that renders one sample of an image alone: the same with --replay, and the instruction set it had.
std::string replay_command(const Job& job, const transport::RenderOutput& output,
                           const std::vector<std::string>& arguments, const display::InvalidSample& sample);
/// How many samples were refused, and where and how to see the first one.
std::string text_of_invalid(const Job& job, const transport::RenderOutput& output,
                            const std::vector<std::string>& arguments);

/// String attributes for the image header: version, revision, command, job text, scene, seed, samples, threads,
/// instruction set, integrator, sampler, filter, compiler, host, time, colour config.
std::map<std::string, std::string> header_attributes(const Job& job, const transport::RenderOutput& output,
                                                     const std::vector<std::string>& arguments,
                                                     const std::string& color_config);

}  // namespace raylex::experiments
