// The importer asks the registries which parameters a type has. The fuzz target of scenes stands alone, without the
// materials, lights and integrators that would fill them.
#include "transport/integrators/integrator.h"
#include "transport/lights/light_table.h"
#include "transport/materials/material.h"
#include "transport/materials/normal_detail.h"
#include "transport/media/medium.h"
#include "transport/scene/sampler.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {

template <class Factory>
Registry<Factory>& empty_registry(const char* kind) {
    static Registry<Factory> registry(kind);
    return registry;
}

Registry<MaterialFactory>& material_registry() {
    return empty_registry<MaterialFactory>("material");
}
Registry<PatternFactory>& pattern_registry() {
    return empty_registry<PatternFactory>("texture");
}
Registry<LightFactory>& light_registry() {
    return empty_registry<LightFactory>("light source");
}
Registry<AreaLightFactory>& area_light_registry() {
    return empty_registry<AreaLightFactory>("area light source");
}
Registry<MediumFactory>& medium_registry() {
    return empty_registry<MediumFactory>("medium");
}
Registry<SamplerFactory>& sampler_registry() {
    return empty_registry<SamplerFactory>("sampler");
}
Registry<IntegratorFactory>& integrator_registry() {
    return empty_registry<IntegratorFactory>("integrator");
}

/// Of materials, of which none is known here.
const std::vector<ParameterDescription>& normal_detail_parameters() {
    static const std::vector<ParameterDescription> none;
    return none;
}

}  // namespace raylex::transport
