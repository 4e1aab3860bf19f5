// Measures the share of raw Embree throughput that a render reaches on the rays that it traces.
//
//   bench_rays SCENE.pbrt [SAMPLES] [ROUNDS]
//
// One render logs every ray in the order of tracing. Each round then runs two things on one thread: the render without
// a log (A), and its rays alone through rtcIntersect1 and rtcOccluded1 (B), with the same flags and instruction set.
// The program prints each round's ratio B / A of CPU seconds, and the medians of the ratio and of both rates in rays
// per CPU second.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "display/services/processor.h"
#include "transport/embree/embree_scene.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/built_scene.h"

using namespace raylex;
using namespace raylex::transport;

namespace {

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

double trace_again(const EmbreeScene& geometry, const RayLog& log, std::uint64_t expected_hits) {
    const double start = cpu_seconds();
    const std::uint64_t hits = geometry.trace_bare(log);
    const double seconds = cpu_seconds() - start;
    if (hits != expected_hits) {
        std::fprintf(stderr, "bench_rays: %llu hits instead of %llu; expected the same rays\n",
                     static_cast<unsigned long long>(hits), static_cast<unsigned long long>(expected_hits));
        std::exit(1);
    }
    return seconds;
}

template <class T>
T value_or_exit(Result<T> result) {
    if (!result) {
        std::fprintf(stderr, "bench_rays: %s\n", result.error().to_string().c_str());
        std::exit(2);
    }
    return std::move(*result);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: bench_rays SCENE.pbrt [SAMPLES] [ROUNDS]\n"), 2;
    const SceneDescription description = value_or_exit(import_pbrt(argv[1]));
    const auto scene = value_or_exit(BuiltScene::build(description));
    RenderSettings settings;
    settings.machine.threads = 1;
    settings.samples.per_pixel = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 16;
    const int rounds = argc > 3 ? std::atoi(argv[3]) : 5;
    const EmbreeScene& geometry = *scene->view().geometry;

    RayLog log;
    geometry.record(&log);
    value_or_exit(render(*scene, settings));
    geometry.record(nullptr);
    display::flush_denormals();
    std::size_t shadow = 0;
    for (const RayLog::Batch& batch : log.batches) shadow += batch.shadow ? batch.count : 0;
    const auto rays = static_cast<double>(log.rays.size());
    const std::uint64_t hits = geometry.trace_bare(log);
    std::printf("%zu closest-hit rays and %zu shadow rays in %zu batches, of which %.1f %% hit; %s\n",
                log.rays.size() - shadow, shadow, log.batches.size(), 100 * static_cast<double>(hits) / rays,
                geometry.isa().c_str());

    std::vector<double> shares, samples_rate, render_rate, raw_rate;
    for (int round = 0; round < rounds; ++round) {
        const RenderOutput output = value_or_exit(render(*scene, settings));
        const double whole = output.statistics.render_cpu_seconds;
        const double raw = trace_again(geometry, log, hits);
        shares.push_back(raw / whole);
        samples_rate.push_back(static_cast<double>(output.statistics.camera_samples) / whole);
        render_rate.push_back(rays / whole);
        raw_rate.push_back(rays / raw);
        std::printf("round %d: render %.3f CPU s, its rays alone %.3f CPU s, share %.3f\n", round + 1, whole, raw,
                    raw / whole);
    }
    std::printf(
        "median: %.2f M samples and %.2f M rays per CPU second; raw %.1f M rays per CPU second; share of raw "
        "throughput %.1f %%\n",
        median(samples_rate) / 1e6, median(render_rate) / 1e6, median(raw_rate) / 1e6, 100 * median(shares));
    return 0;
}
