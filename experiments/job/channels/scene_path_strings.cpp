#include "experiments/job/channels/scene_path_strings.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "experiments/job/job_file.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/integrators/integrator.h"
#include "transport/scene/effects/material_kinds.h"

namespace raylex::experiments {

lpe::PathStrings ScenePathStrings::with_user_events() const {
    lpe::PathStrings more = words;
    if (more.alphabet) more.alphabet->scattering.insert(more.alphabet->scattering.end(), user.begin(), user.end());
    return more;
}

Result<ScenePathStrings> scene_path_strings(const Job& job, const transport::SceneDescription& scene,
                                            const transport::BuiltScene* built) {
    const lpe::LobeSlots& slots = job.settings.labels.lobe_slots;
    auto chosen = transport::choose_integrator(
        transport::integrator_for(job.settings.paths.integrator, scene.integrator), job.settings.paths.max_depth);
    if (!chosen) return chosen.error();
    const transport::IntegratorTraits traits = chosen->integrator->traits();
    Result<transport::SceneAlphabet> alphabet =
        built != nullptr ? transport::scene_alphabet(scene, *built, slots, traits.regularizes)
                         : transport::scene_alphabet(scene, slots, traits.regularizes);
    if (!alphabet) return alphabet.error();

    ScenePathStrings result;
    result.alphabet = std::move(*alphabet);
    result.words.alphabet = lpe::Alphabet{result.alphabet.scattering, result.alphabet.terminals};
    // Words contain the scattering events inside subsurface bodies, but "maxdepth" does not count them.
    const bool bounded = std::none_of(scene.materials.begin(), scene.materials.end(), transport::is_subsurface);
    if (traits.max_depth && bounded)
        result.words.max_depth =
            static_cast<int>(std::min<std::int64_t>(*traits.max_depth, std::numeric_limits<int>::max()));
    if (traits.user_events)
        for (const std::string& label : result.alphabet.object_labels)
            for (std::size_t i = 0; i < transport::user_lobes.size(); ++i)
                result.user.push_back(
                    transport::user_event(label, static_cast<transport::UserLobe>(i), job.settings.labels.lobe_slots));
    const auto is_holdout = [](const transport::SceneShape& shape) { return shape.holdout; };
    result.holdouts = std::any_of(scene.shapes.begin(), scene.shapes.end(), is_holdout);
    for (const transport::SceneObject& object : scene.objects)
        result.holdouts = result.holdouts || std::any_of(object.shapes.begin(), object.shapes.end(), is_holdout);
    for (const transport::SceneInstance& instance : scene.instances)
        result.holdouts = result.holdouts || instance.holdout.value_or(false);
    return result;
}

Result<ScenePathStrings> read_scene_path_strings(const std::string& path) {
    const auto job = read_scene_or_job(path);
    if (!job) return job.error();
    auto scene = transport::import_pbrt(job->scene_file, {.missing = job->missing});
    if (!scene) return scene.error();
    if (Status labelled = transport::apply_label_rules(*scene, job->label_rules); !labelled) return labelled.error();
    return scene_path_strings(*job, *scene);
}

}  // namespace raylex::experiments
