// Cost of compiling sets of channels and of following a path through them. Event classes are asked for beforehand, as an
// integrator does once per kind of event.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "lpe/check.h"
#include "lpe/program.h"
#include "lpe/shipped.h"

namespace {

using namespace raylex::lpe;

std::vector<ChannelSource> read_set(const std::string& name, std::size_t count) {
    std::ifstream file(std::string(RAYLEX_SOURCE_DIR) + "/tests/lpe/data/lpe_bench_" + name + ".txt");
    std::vector<ChannelSource> channels;
    for (std::string line; channels.size() < count && std::getline(file, line);) {
        ChannelSource channel;
        channel.name = line;
        channel.expression = line;
        channel.dialect = Dialect::osl;
        channels.push_back(std::move(channel));
    }
    if (channels.size() != count) {
        std::cerr << "benchmark set '" << name << "' has fewer than " << count << " expressions\n";
        std::exit(2);
    }
    return channels;
}

Program compile_or_exit(const std::vector<ChannelSource>& channels) {
    auto program = Program::compile(channels);
    if (!program) {
        std::cerr << program.error().to_string() << "\n";
        std::exit(2);
    }
    return std::move(*program);
}

/// Paths as event classes, one after the other: camera, up to six scatterings, a terminal. A fixed linear congruence
/// (Knuth, MMIX) draws them.
std::vector<EventClass> random_paths(const Program& program, std::size_t paths) {
    const std::vector<std::string> objects{"floor", "wall", "hero", "glass", "skin", ""};
    const std::vector<std::string> lights{"key", "fill", "rim", "env", ""};
    std::uint64_t state = 1;
    const auto below = [&state](std::size_t bound) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<std::size_t>(state >> 33) % bound;
    };
    std::vector<EventClass> events;
    for (std::size_t k = 0; k < paths; ++k) {
        events.push_back(program.classify({EventType::camera, Scatter::none, 0, {}}));
        for (std::size_t length = 1 + below(6); length > 0; --length) {
            const EventType type = below(3) == 0 ? EventType::transmission : EventType::reflection;
            const Scatter scatter = static_cast<Scatter>(1 + below(3));
            events.push_back(program.classify({type, scatter, 0, {objects[below(objects.size())], ""}}));
        }
        events.push_back(program.classify({EventType::light, Scatter::none, 0, {lights[below(lights.size())]}}));
    }
    return events;
}

void follow(benchmark::State& state, const std::string& set) {
    const Program program = compile_or_exit(read_set(set, static_cast<std::size_t>(state.range(0))));
    const std::vector<EventClass> events = random_paths(program, 4096);
    const EventClass camera = events.front();
    const std::size_t groups = program.group_count();
    for (auto _ : state) {
        for (std::size_t group = 0; group < groups; ++group) {
            State at = program.starts()[group];
            for (const EventClass event : events) {
                at = program.next(event == camera ? program.starts()[group] : at, event);
                benchmark::DoNotOptimize(at);
            }
        }
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(events.size()));
    state.counters["time/event"] =
        benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(events.size()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["states"] = static_cast<double>(program.state_count());
    state.counters["groups"] = static_cast<double>(groups);
}

void compile(benchmark::State& state, const std::string& set) {
    const auto channels = read_set(set, static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) {
        benchmark::DoNotOptimize(compile_or_exit(channels));
    }
}

void prove_shipped(benchmark::State& state) {
    std::vector<ChannelSource> channels;
    for (const NamedExpression& entry : shipped_partition()) {
        ChannelSource channel;
        channel.name = entry.name;
        channel.expression = entry.expression;
        channels.push_back(std::move(channel));
    }
    for (auto _ : state) {
        const auto report = check_partition(channels);
        if (!report || report->verdict != Verdict::partition) {
            state.SkipWithError("the shipped partition was not proved");
            return;
        }
    }
}

}  // namespace

BENCHMARK_CAPTURE(follow, firsthit, "firsthit")->Arg(1)->Arg(8)->Arg(32)->Arg(64)->Arg(128);
BENCHMARK_CAPTURE(follow, anywhere, "anywhere")->Arg(64)->Arg(128);
BENCHMARK_CAPTURE(compile, firsthit, "firsthit")->Arg(1)->Arg(8)->Arg(32)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile, anywhere, "anywhere")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(prove_shipped)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
