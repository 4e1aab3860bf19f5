// Parameters that several integrators have: how they are read, and what the registry says of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "transport/paths/subpath.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/parameter_reader.h"

namespace raylex::transport {

/// Reads the parameters of an integrator. The first error is kept; later reads give fallbacks.
class IntegratorParameters : public ParameterReader {
  public:
    explicit IntegratorParameters(const SceneEntity& entity) : ParameterReader(entity.parameters), entity_(entity) {}

    /// "maxdepth": scattering events, 5 without, at most a million; `forced` comes first.
    std::uint32_t max_depth(std::optional<std::int64_t> forced);
    /// "roulette" and "rrthreshold": the throughput below which paths end at random; 0: none does.
    Real roulette_below();
    /// The position among `names` of the string that is given.
    std::size_t choice(std::string_view name, const std::vector<std::string>& names, std::size_t fallback);
    /// A number in (0, 1].
    Real fraction(std::string_view name, Real fallback, const std::string& reason = {});

  private:
    const SceneEntity& entity_;
};

ParameterDescription describe_max_depth();
/// `who` ends at random: "paths", "subpaths".
ParameterDescription describe_roulette(const std::string& who);
ParameterDescription describe_roulette_threshold();

/// The parameters "maxdepth", "roulette" and "rrthreshold".
struct DepthParameters {
    std::uint32_t max_depth = 5;  ///< scattering events at most
    Real roulette_below = default_roulette_below;
};
DepthParameters read_depth_parameters(IntegratorParameters& read, std::optional<std::int64_t> max_depth);
std::vector<ParameterDescription> describe_depth_parameters(const std::string& who);

}  // namespace raylex::transport
