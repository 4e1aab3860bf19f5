// Parameters that several integrators have: their readers, and their descriptions for the registry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "transport/integrators/guide_request.h"
#include "transport/paths/subpath.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/parameter_reader.h"

namespace raylex::transport {

/// Reads the parameters of an integrator. It keeps the first error; later reads return fallbacks.
class IntegratorParameters : public ParameterReader {
  public:
    explicit IntegratorParameters(const SceneEntity& entity) : ParameterReader(entity.parameters), entity_(entity) {}

    /// "maxdepth", the number of scattering events: `forced` if set, else the parameter, else 5; at most a million.
    std::uint32_t max_depth(std::optional<std::int64_t> forced);
    /// "roulette" and "rrthreshold": the throughput below which paths end at random. 0: no path ends at random.
    Real roulette_below();
    /// The position in `names` of the parameter's string.
    std::size_t choice(std::string_view name, const std::vector<std::string>& names, std::size_t fallback);
    /// A number in (0, 1].
    Real fraction(std::string_view name, Real fallback, const std::string& reason = {});

  private:
    const SceneEntity& entity_;
};

ParameterDescription describe_max_depth();
/// Describes "roulette". `who` are the paths that end at random: "paths", "subpaths".
ParameterDescription describe_roulette(const std::string& who);
ParameterDescription describe_roulette_threshold();

/// The parameters "maxdepth", "roulette" and "rrthreshold".
struct DepthParameters {
    std::uint32_t max_depth = 5;  ///< scattering events at most
    Real roulette_below = default_roulette_below;
};
DepthParameters read_depth_parameters(IntegratorParameters& read, std::optional<std::int64_t> max_depth);
std::vector<ParameterDescription> describe_depth_parameters(const std::string& who);

/// The parameters of methods whose camera subpaths a guide may draw: guide, guidesamples. make_trial stays empty.
GuideRequest read_guide_parameters(IntegratorParameters& read);
std::vector<ParameterDescription> describe_guide_parameters();

}  // namespace raylex::transport
