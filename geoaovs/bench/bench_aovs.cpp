// Measures the cost of geometric AOVs between first hits and the frame buffer's record. Part of bench_lpe.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "geoaovs/geoaovs.h"

namespace {

using namespace raylex;

/// Batches of 256 camera samples, 64 for each of four pixels, into an image that does not fit in the caches. Arguments:
/// number of AOVs (up to ten), and whether the beauty keeps statistics.
void aovs(benchmark::State& state) {
    constexpr int width = 200, height = 200, rows = 256, samples = 64, pixels = rows / samples;
    std::vector<display::ChannelDefinition> channels(1);
    channels[0].name = "beauty";
    channels[0].style = display::ChannelStyle::expression;
    channels[0].statistics = state.range(1) != 0;
    const char* const names[] = {"P", "Nn", "Ngn", "st", "albedo", "u", "v", "z", "id", "VLen"};
    for (int i = 0; i < state.range(0); ++i) {
        auto definition = geoaovs::channel_definition(names[i]);
        if (!definition) return state.SkipWithError(definition.error().to_string().c_str());
        channels.push_back(*std::move(definition));
    }
    const geoaovs::GeometricAovs written(channels);
    geoaovs::ShadingBatch hits;
    hits.resize(rows, written.inputs());
    geoaovs::RayBatch rays{std::vector<float>(rows, 0.0f), std::vector<float>(rows, 1.0f)};
    float value = 0.25f;
    const auto fill = [&](std::vector<float>& column) {
        for (float& each : column) each = value = 4 * value * (1 - value) * 0.99f;
    };
    for (auto* columns : {&hits.position, &hits.shading_normal, &hits.geometric_normal, &hits.albedo})
        for (auto& column : *columns) fill(column);
    for (auto* column : {&hits.s, &hits.t, &hits.u, &hits.v}) fill(*column);
    for (int c = 0; c < 3; ++c) hits.world_to_camera[c][c] = 1;
    for (int row = 0; row < rows; ++row) hits.row[static_cast<std::size_t>(row)] = row;

    display::FrameBuffer buffer({width, height}, channels);
    display::SampleTable table(channels, rows);
    display::DisplayServices services(table);
    std::vector<display::CameraRow> camera(rows);
    int pixel = 0;
    for (auto _ : state) {
        for (int row = 0; row < rows; ++row) {
            display::CameraRow& each = camera[static_cast<std::size_t>(row)];
            const int at = (pixel + row / samples) % (width * height);
            each.pixel_x = at % width;
            each.pixel_y = at / width;
            each.sample = static_cast<std::uint64_t>(row % samples);
        }
        pixel += pixels;
        table.begin(camera);
        double* const beauty = table.raw_values(0);
        table.touch(0);
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t c = 0; c < 3; ++c) beauty[3 * row + c] = static_cast<double>(hits.row[row] & 15);
            table.depth[row] = static_cast<float>(2 + (row & 3));
        }
        written.write(hits, services);
        if (written.wants_rays()) written.write_rays(rays, table, services);
        buffer.accumulate(table);
    }
    state.counters["time/sample"] = benchmark::Counter(static_cast<double>(state.iterations()) * rows,
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

}  // namespace

BENCHMARK(aovs)->Args({0, 0})->Args({0, 1})->Args({1, 0})->Args({7, 0})->Args({10, 0})->Args({10, 1});
