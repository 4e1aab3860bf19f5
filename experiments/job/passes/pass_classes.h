// Expressions of classes of paths: unions, differences, channels within a class, and paths that a method misses.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "display/services/channel.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/path_strings.h"
#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::experiments {

/// Splits "lpe:prefix;prefix;language" into its prefixes, with the last semicolon, and the language.
std::pair<std::string, std::string> split_prefixes(const std::string& expression);

/// Returns an expression of the paths that at least one of the expressions accepts.
std::string any_path_of(const std::vector<std::string>& expressions);
/// Returns an expression of the paths of `whole` that none of the others accepts.
std::string paths_without(const std::string& whole, const std::vector<std::string>& others);

/// Returns the channel restricted to a class. `channels` are those that its `rest_of` names; the result has none.
display::ChannelDefinition channel_within(const display::ChannelDefinition& channel,
                                          const std::vector<display::ChannelDefinition>& channels,
                                          const std::string& of_class);

/// A path that a method does not sample, and the methods that do.
struct MissedPath {
    lpe::Witness witness;
    std::vector<std::string> methods;
};

/// Returns the shortest path of a class that the method misses in this scene although another of path, lighttracer and
/// bdpt samples it. A path that none of them samples is black in every render and does not count.
Result<std::optional<MissedPath>> find_missed_path(const std::string& of_class, const transport::SceneEntity& method,
                                                   const transport::SceneDescription& scene,
                                                   const lpe::PathStrings& words);

/// Returns whether the light of a method belongs to samples of a pixel, and not to raster positions of light paths.
bool is_camera_based(const transport::SceneEntity& method, std::optional<std::int64_t> max_depth);

}  // namespace raylex::experiments
