#include "transport/integrators/omitted_paths.h"

#include <map>
#include <utility>

namespace raylex::transport {
namespace {

std::multimap<std::string, OmittedPaths>& declarations() {
    // A light path is joined to the camera at its last scattering, which a singular one cannot be.
    static std::multimap<std::string, OmittedPaths> all{{"lighttracer", {"C<.S>.*", lpe::Dialect::osl}}};
    return all;
}

}  // namespace

std::vector<OmittedPaths> omitted_paths(const std::string& integrator) {
    std::vector<OmittedPaths> paths;
    const auto [first, last] = declarations().equal_range(integrator);
    for (auto each = first; each != last; ++each) paths.push_back(each->second);
    return paths;
}

void declare_omitted_paths(const std::string& integrator, OmittedPaths paths) {
    declarations().emplace(integrator, std::move(paths));
}

}  // namespace raylex::transport
