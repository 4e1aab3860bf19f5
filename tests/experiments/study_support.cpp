#include "study_support.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <random>

#include "experiments/study/results_file.h"

namespace raylex::test {
namespace {

using namespace raylex::experiments;

/// Returns the mean light of a channel: a smooth ramp with a bright disc, so that pictures can be distinguished.
double truth(int channel, double u, double v, int c) {
    const double disc = std::hypot(u - 0.6, v - 0.45) < 0.2 ? 1.5 : 0;
    const double base = 0.15 + 0.6 * u * (1 - 0.5 * v) + (channel == 1 ? disc : 0.3 * v);
    return base * (c == 0 ? 1 : c == 1 ? 0.8 : 0.55) / channel;
}

struct Images {
    std::vector<PixelArray> mean, m2;  ///< by channel, the beauty first
};

Images simulate(const SyntheticStudy& study, double samples, std::mt19937_64& random, double second, double all) {
    const auto w = static_cast<std::size_t>(study.width), h = static_cast<std::size_t>(study.height);
    std::normal_distribution<double> normal;
    Images images;
    images.mean.assign(static_cast<std::size_t>(study.channels),
                       PixelArray{h, w, 3, std::vector<double>(w * h * 3, 0.0)});
    images.m2 = images.mean;
    for (std::size_t i = 0; i < w * h * 3; ++i) {
        const std::size_t pixel = i / 3;
        const double u = static_cast<double>(pixel % w) / study.width,
                     v = static_cast<double>(pixel / w) / study.height;
        for (std::size_t k = 1; k < images.mean.size(); ++k) {
            const double exact = truth(static_cast<int>(k), u, v, static_cast<int>(i % 3));
            const double deviation = study.noise * exact / std::sqrt(samples);
            images.mean[k].values[i] = exact * all * (k == 2 ? second : 1) + deviation * normal(random);
            images.m2[k].values[i] = deviation * deviation * samples * (samples - 1);
            images.mean[0].values[i] += images.mean[k].values[i];
            images.m2[0].values[i] += images.m2[k].values[i];
        }
    }
    return images;
}

void write_images(const std::string& directory, const SceneInfo& scene, const Images& images, double samples) {
    std::filesystem::create_directories(directory);
    for (std::size_t k = 0; k < images.mean.size(); ++k) {
        REQUIRE(write_npy(directory + "/" + scene.channels[k].name + ".mean.npy", images.mean[k]));
        // A report needs variances only of references.
        if (directory == scene.reference)
            REQUIRE(write_npy(directory + "/" + scene.channels[k].name + ".m2.npy", images.m2[k]));
    }
    const std::size_t pixels = images.mean[0].width * images.mean[0].height;
    REQUIRE(write_npy_counts(directory + "/samples.npy", images.mean[0].height, images.mean[0].width,
                             std::vector<std::uint64_t>(pixels, static_cast<std::uint64_t>(samples))));
}

SceneInfo scene_of(const SyntheticStudy& study, const std::string& root, int index, std::mt19937_64& random) {
    SceneInfo scene;
    scene.name = index == 0 ? "ramp" : "ramp-" + std::to_string(index);
    scene.file = scene.name + ".pbrt";
    scene.hash = "0";
    scene.width = study.width;
    scene.height = study.height;
    scene.channels.push_back({"beauty", "C.*", "renderman", true});
    for (int k = 1; k < study.channels; ++k) {
        std::string bounces(static_cast<std::size_t>(k), '.');
        std::string expression = "C";
        for (int i = 0; i < k; ++i) expression += "[DSV]";
        scene.channels.push_back({"bounce" + std::to_string(k), expression + "[<L.>O]", "renderman", false});
    }
    scene.reference = root + "/references/" + scene.name;
    scene.reference_method = "path";
    scene.reference_samples = 65536;
    scene.reference_relative_error = study.noise / 256;
    write_images(scene.reference, scene, simulate(study, 65536, random, 1, 1), 65536);
    REQUIRE(raylex::display::write_text_file(scene.reference + "/reference.json", "{}"));
    return scene;
}

}  // namespace

Experiment write_synthetic_study(const Folder& folder, const SyntheticStudy& study) {
    std::mt19937_64 random(20);
    const std::string root = folder.path("study");
    std::filesystem::create_directories(root + "/cells");
    std::filesystem::create_directories(root + "/failed");
    Experiment experiment;
    experiment.name = "synthetic <study>";
    experiment.directory = root;
    experiment.config_text = "name = \"synthetic <study>\"  # </script> & more\n";
    experiment.config_hash = "abc";
    experiment.provenance = {{"revision", "none"}, {"machine", "2 cores"}};
    experiment.methods = {{"path", "path", "", true, {{"max_depth", "9"}}},  // its cells sweep it
                          {"skewed", "path", "", true, {{"max_depth", "4"}, {"integrator.strategy", "light"}}},
                          {"clamped",
                           "path",
                           "",
                           false,
                           {{"max_depth", "4"}, {"sample_filter.type", "clamp"}, {"sample_filter.luminance", "10"}}}};
    experiment.partitions = {{"bounces", "beauty", {"bounce1", "bounce2"}}};
    for (int s = 0; s < study.scenes; ++s) experiment.scenes.push_back(scene_of(study, root, s, random));
    for (const SceneInfo& scene : experiment.scenes)
        for (int budget = 0; budget < study.budgets; ++budget)
            for (int replicate = 0; replicate < study.replicates; ++replicate)
                for (int variant = 0; variant < study.variants; ++variant) {
                    const double samples = 16 * std::exp2(budget);
                    StudyRun run;
                    run.scene = scene.name;
                    run.method = experiment.methods[static_cast<std::size_t>(variant < 3 ? variant : 0)].name;
                    if (run.method == "path")
                        run.settings = {{"max_depth", std::to_string(variant < 3 ? 4 : 2 + variant)}};
                    run.id = scene.name + ".v" + std::to_string(variant) + "." + std::to_string(budget) + ".r" +
                             std::to_string(replicate);
                    run.budget = samples;
                    run.replicate = static_cast<unsigned>(replicate);
                    run.seed = experiment.runs.size() + 1;
                    run.samples_per_pixel = static_cast<std::uint64_t>(samples);
                    run.phases = {{"load", 0.05, 0.05},
                                  {"build", 0.01, 0.02},
                                  {"prepare", 0.06, 0.07},
                                  {"render", samples * 0.01 * (1 + 0.1 * variant), samples * 0.02},
                                  {"write", 0.2, 0.1}};
                    for (const Phase& phase : run.phases) {
                        // other phases do not count as its time
                        if (phase.name != "prepare" && phase.name != "render") continue;
                        run.wall_seconds += phase.wall_seconds;
                        run.cpu_seconds += phase.cpu_seconds;
                    }
                    run.rays = 1000000;
                    run.splits = {{"bounces", true, 1e-8}};
                    run.directory = root + "/cells/" + run.id;
                    write_images(run.directory, scene,
                                 simulate(study, samples, random, run.method == "skewed" ? 1.05 : 1,
                                          run.method == "clamped" ? 0.9 : 1),
                                 samples);
                    REQUIRE(write_run_file(run.directory + "/cell.json", run));
                    experiment.runs.push_back(run);
                }
    StudyRun failed = experiment.runs.front();
    failed.id += "x";
    failed.failed = true;
    failed.failure = "killed by the <system>";
    failed.directory.clear();
    REQUIRE(write_run_file(root + "/failed/" + failed.id + ".json", failed));
    experiment.runs.push_back(failed);
    experiment.missing = {"ramp.path.999.r0"};
    return experiment;
}

}  // namespace raylex::test
