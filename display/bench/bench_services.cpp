// Measures the cost of attribution (Law 5): the state vector when two or more lobes overlap at every event, and
// contributions to a sample table. Part of bench_lpe.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "lpe/bench/sets.h"

namespace {

using namespace raylex;
using namespace raylex::display;

std::vector<ChannelDefinition> display_channels(const std::string& set, std::size_t count) {
    std::vector<ChannelDefinition> channels(1);
    channels[0].name = "beauty";
    for (const lpe::ChannelSource& source : lpe::bench::named_set(set, count)) {
        ChannelDefinition channel;
        channel.name = source.name;
        channel.style = ChannelStyle::expression;
        channel.expression = source.expression;
        channel.dialect = source.dialect;
        channels.push_back(std::move(channel));
    }
    return channels;
}

LpeSetup setup_or_exit(const std::vector<ChannelDefinition>& channels) {
    auto setup = LpeSetup::build(channels, 0);
    if (!setup) {
        std::fprintf(stderr, "%s\n", setup.error().to_string().c_str());
        std::exit(2);
    }
    return std::move(*setup);
}

/// Follows paths of `depth` scattering events with `lobes` overlapping lobes each. Arguments: channels, lobes, depth.
void law5(benchmark::State& state, const std::string& set) {
    const auto channels = display_channels(set, static_cast<std::size_t>(state.range(0)));
    const auto lobes = static_cast<std::size_t>(state.range(1)), depth = static_cast<std::size_t>(state.range(2));
    const LpeSetup setup = setup_or_exit(channels);
    SampleTable table(channels, 1);
    table.begin(std::vector<CameraRow>(1));
    LpeServices services(setup, table, 0);
    constexpr std::size_t paths = 256, most_lobes = 4;
    const std::array<lpe::Scatter, most_lobes> scatter{lpe::Scatter::diffuse, lpe::Scatter::glossy,
                                                       lpe::Scatter::singular, lpe::Scatter::glossy};
    const std::vector<std::string> objects{"floor", "wall", "hero", "glass", "skin", ""};
    lpe::bench::Random random;
    std::vector<std::array<LobePart, most_lobes>> vertices(paths * depth);
    for (auto& vertex : vertices) {
        const std::string& object = objects[random.below(objects.size())];
        for (std::size_t j = 0; j < most_lobes; ++j) {
            const auto type = j == 3 ? lpe::EventType::transmission : lpe::EventType::reflection;
            vertex[j] = {setup.classify({type, scatter[j], 0, {object, ""}}),
                         Rgb(0.1f + 0.01f * static_cast<float>(random.below(90)), 0.4f, 0.3f)};
        }
    }
    double branches = 0;
    for (auto _ : state) {
        for (std::size_t path = 0; path < paths; ++path) {
            Tracker tracker = services.begin(0);
            for (std::size_t k = 0; k < depth; ++k) {
                services.move(tracker, std::span(vertices[path * depth + k]).first(lobes));
            }
            benchmark::DoNotOptimize(tracker);
            branches += tracker.branches();
        }
    }
    const double runs = static_cast<double>(state.iterations()) * static_cast<double>(paths);
    state.counters["time/event"] = benchmark::Counter(runs * static_cast<double>(depth),
                                                      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["branches at the end"] = branches / runs;
}

/// Contributes to beauty and to every accepting channel, along a path without overlapping lobes. Argument: channels.
void contribute(benchmark::State& state, const std::string& set) {
    const auto channels = display_channels(set, static_cast<std::size_t>(state.range(0)));
    const LpeSetup setup = setup_or_exit(channels);
    SampleTable table(channels, 1);
    table.begin(std::vector<CameraRow>(1));
    LpeServices services(setup, table, 0);
    std::vector<Tracker> ends;
    double matches = 0;
    const auto paths = lpe::bench::random_paths(512);
    for (const lpe::bench::RandomPath& path : paths) {
        Tracker tracker = services.begin(0);
        for (std::size_t k = 1; k < path.events.size(); ++k) services.move(tracker, setup.classify(path.events[k]));
        ends.push_back(tracker);
        std::vector<lpe::State> words(setup.program().starts().begin(), setup.program().starts().end());
        for (const lpe::Event& event : path.events)
            setup.program().advance(words.data(), setup.classify(event), words.data());
        setup.program().for_each_accepted(words.data(), [&](std::uint16_t) { ++matches; });
    }
    for (auto _ : state) {
        for (const Tracker& tracker : ends) services.contribute(Rgb(0.25f, 0.5f, 0.75f), Technique{}, tracker);
        benchmark::ClobberMemory();
    }
    const double count = static_cast<double>(paths.size());
    state.counters["time/event"] = benchmark::Counter(static_cast<double>(state.iterations()) * count,
                                                      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["channels"] = matches / count;
}

}  // namespace

BENCHMARK_CAPTURE(law5, firsthit, "firsthit")
    ->ArgsProduct({{8, 32, 64, 128}, {2}, {6}})
    ->ArgsProduct({{64}, {1, 3, 4}, {6}})
    ->ArgsProduct({{64}, {2}, {1, 3, 12, 24}});
BENCHMARK_CAPTURE(law5, anywhere, "anywhere")->Args({128, 2, 6});
BENCHMARK_CAPTURE(law5, mixture, "mixture")->Args({128, 2, 6});
BENCHMARK_CAPTURE(contribute, firsthit, "firsthit")->Arg(0)->Arg(32)->Arg(64);
