// The JSON fields of results (results.h) that files and messages have in common.
#pragma once

#include <cmath>

#include "experiments/job/text/json_fields.h"
#include "experiments/study/results.h"

namespace raylex::experiments {

/// JSON has no infinity, which is stored as null.
struct NullIsInfinite {
    double& value;
};
inline void to_json(Json& json, const NullIsInfinite& number) {
    json = number.value;
}
inline void from_json(const Json& json, NullIsInfinite& number) {
    number.value = json.is_null() ? HUGE_VAL : json.get<double>();
}

RAYLEX_JSON_FIELDS(Phase, name, wall_seconds, cpu_seconds)
RAYLEX_JSON_FIELDS(PassResult, name, method, samples_per_pixel, cpu_seconds)
RAYLEX_JSON_FIELDS(FileRecord, name, bytes, hash)
RAYLEX_JSON_FIELDS(OmittedPathsInfo, expression, dialect)
RAYLEX_JSON_FIELDS(ChannelInfo, name, expression, dialect, beauty)
RAYLEX_JSON_FIELDS(MethodInfo, name, integrator, command, unbiased, settings)
RAYLEX_JSON_FIELDS(Region, name, scene, crop, mask_file)
RAYLEX_JSON_FIELDS(PartitionInfo, name, of, channels)

void visit_fields(auto visit, PartitionResult& result) {
    visit("partition", result.partition);
    visit("holds", result.holds);
    visit("worst_relative_error", NullIsInfinite{result.worst_relative_error});
}

void visit_fields(auto visit, SceneInfo& scene) {
    visit("name", scene.name);
    visit("file", scene.file);
    visit("hash", scene.hash);
    visit("width", scene.width);
    visit("height", scene.height);
    visit("channels", scene.channels);
    visit("reference", scene.reference);
    visit("reference_relative_error", scene.reference_relative_error);
    visit("reference_method", scene.reference_method);
    visit("reference_samples", scene.reference_samples);
    visit.optional("reference_failure", scene.reference_failure, !scene.reference_failure.empty());
}

}  // namespace raylex::experiments
