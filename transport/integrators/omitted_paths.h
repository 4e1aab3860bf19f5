// Light paths that an integrator does not find, however long it renders. Each integrator declares them here, so that
// comparisons of images do not report them as errors, and passes of several integrators miss nothing.
#pragma once

#include <string>
#include <vector>

#include "lpe/program.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct OmittedPaths {
    std::string expression;  ///< a light path expression of all of them
    lpe::Dialect dialect = lpe::Dialect::osl;
};

/// The omitted paths of the integrator with this name in the registry. Empty if it finds all, or declares none.
std::vector<OmittedPaths> omitted_paths(const std::string& integrator);

/// The paths that the integrator with this name in the registry omits in this scene: omitted_paths(integrator), and
/// those to lights that no ray hits (points, spots, distant lights, hidden area lights). A light group with such a
/// light counts as a whole, because a path string names the group and not the light.
std::vector<OmittedPaths> omitted_paths(const SceneEntity& integrator, const SceneDescription& scene);

/// Declares omitted paths. Plugins call it beside their entry in the registry.
void declare_omitted_paths(const std::string& integrator, OmittedPaths paths);

}  // namespace raylex::transport
