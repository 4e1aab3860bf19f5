// Light paths that an integrator does not find, however long it renders. Each integrator declares them here, so that
// comparisons of images do not report them as errors.
#pragma once

#include <string>
#include <vector>

#include "lpe/program.h"

namespace raylex::transport {

struct OmittedPaths {
    std::string expression;  ///< a light path expression of all of them
    lpe::Dialect dialect = lpe::Dialect::osl;
};

/// The omitted paths of the integrator with this name in the registry. Empty if it finds all, or declares none.
std::vector<OmittedPaths> omitted_paths(const std::string& integrator);

/// Declares omitted paths. Plugins call it beside their entry in the registry.
void declare_omitted_paths(const std::string& integrator, OmittedPaths paths);

}  // namespace raylex::transport
