// Jobs with passes, planned and rendered by tests.
#pragma once

#include <catch2/catch.hpp>

#include <bit>
#include <memory>

#include "experiments/job/job_file.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/job_scene.h"
#include "tests/transport/replicates.h"

namespace passes_test {

using namespace raylex::experiments;
using namespace render_test;
using raylex::Result;

/// A scene with the passes of a job, planned and ready to be rendered.
struct PlannedJob {
    Job job;
    std::unique_ptr<JobScene> loaded;
    std::shared_ptr<const transport::BuiltScene> built;
    ChannelPlan channels;
    PassPlan passes;

    [[nodiscard]] JobOutput rendered() const {
        auto output = render_job(job, passes, loaded->scene, *built, {}, nullptr);
        INFO((output ? std::string() : output.error().to_string()));
        REQUIRE(output.ok());
        CHECK(output->output.statistics.invalid_samples == 0);
        return *std::move(output);
    }
};

/// Plans the job `text`, which needs no [scene]; an Error is that of a step before the first ray.
inline Result<PlannedJob> planned(const std::string& scene, const std::string& text) {
    PlannedJob plan;
    auto job = parse_job("scene.file = 'test.pbrt'\n" + text, "job.toml");
    if (!job) return job.error();
    plan.job = *std::move(job);
    if (auto begun = begin_passes(plan.job); !begun) return begun.error();
    auto loaded = prepare_job_scene(plan.job, scene_of(scene));
    if (!loaded) return loaded.error();
    plan.loaded = *std::move(loaded);
    auto built = transport::BuiltScene::build(plan.loaded->scene);
    if (!built) return built.error();
    plan.built = *std::move(built);
    auto words = scene_path_strings(plan.job, plan.loaded->scene, plan.built.get());
    if (!words) return words.error();
    auto channels = plan_channels(plan.job, *words);
    if (!channels) return channels.error();
    plan.channels = *std::move(channels);
    auto passes = plan_passes(plan.job, plan.loaded->scene, *words, plan.channels);
    if (!passes) return passes.error();
    plan.passes = *std::move(passes);
    plan.job.settings.channels.list = plan.channels.channels;
    return plan;
}

inline PlannedJob plan_of(const std::string& scene, const std::string& text) {
    auto plan = planned(scene, text);
    INFO(text << (plan ? std::string() : plan.error().to_string()));
    REQUIRE(plan.ok());
    INFO(plan->passes.refuted);
    REQUIRE(plan->passes.refuted.empty());
    return *std::move(plan);
}

inline std::vector<double> values_of(const JobOutput& rendered, const std::string& name) {
    const display::PixelImage& image = rendered.output.image();
    for (std::size_t i = 0; i < image.channels().size(); ++i)
        if (image.channels()[i].name == name) return image.resolve(static_cast<display::ChannelId>(i));
    FAIL("no channel '" + name + "'");
    return {};
}

inline void check_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
    REQUIRE(a.size() == b.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        different += std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i]) ? 1 : 0;
    CHECK(different == 0);
}

inline std::string pass(const std::string& method, const std::string& takes, const std::string& more = "") {
    return "[[pass]]\nmethod = '" + method + "'\ntakes = \"" + takes + "\"\n" + more;
}
inline std::string channel(const std::string& name, const std::string& expression) {
    return "[[channel]]\nname = '" + name + "'\nlpe = \"" + expression + "\"\n";
}

/// A light above a floor and a glass ball; `light` is its directive.
inline std::string ball_scene(const std::string& light) {
    return plain_film + R"(
LookAt 0 2 5  0 0.5 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
)" + light +
           R"(
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 4 4 0 4 4 0 -4 -4 0 -4]
AttributeBegin Material "dielectric" Translate 0 0.8 0 Shape "sphere" "float radius" 0.6 AttributeEnd
)";
}
inline const std::string point_light = R"(LightSource "point" "rgb I" [20 20 20] "point3 from" [1 4 1])";
inline const std::string area_light =
    R"(AttributeBegin AreaLightSource "diffuse" "rgb L" [20 20 20] Translate 1 3 0 Rotate 90 1 0 0
Shape "disk" "float radius" 0.5 AttributeEnd)";

}  // namespace passes_test
