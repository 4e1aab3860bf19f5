// The proofs that the options of raylex lpe check request, and their results.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/lpe/picture.h"

namespace raylex::experiments {

struct CheckOptions {
    DialectOption dialect;
    ChannelArguments channels;
    ChannelOutput output;
    ReaderOption reader;
    SceneOption scene;
    PathOptions paths;
    lpe::PathStrings words;  // the paths that scene and options allow
    std::string of, what = "partition", rest;
    bool json = false;
};

/// Returns which channels are written for RenderMan itself, which lacks raylex's extensions.
Written written_for_renderman(const CheckOptions& options);

/// Returns one result for all channels; if several files have channels, first one result per file.
Result<std::vector<CheckPicture>> check_files(const CheckOptions& options, const ChannelSet& set,
                                              const std::vector<lpe::ChannelSource>& sources,
                                              const std::optional<lpe::ChannelSource>& of);

}  // namespace raylex::experiments
