// What integrators say of themselves: paths of light that they do not find, however long they render. Who compares
// images reads it, so that nobody is accused of what was said beforehand.
#pragma once

#include <string>
#include <vector>

#include "lpe/program.h"

namespace raylex::transport {

struct OmittedPaths {
    std::string expression;  ///< a light path expression of all of them
    lpe::Dialect dialect = lpe::Dialect::osl;
};

/// Of an integrator by the name in its registry; none where it finds everything, or says nothing.
std::vector<OmittedPaths> omitted_paths(const std::string& integrator);

/// For plugins, beside their entry in the registry.
void declare_omitted_paths(const std::string& integrator, OmittedPaths paths);

}  // namespace raylex::transport
