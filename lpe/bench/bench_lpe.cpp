// Measures compiling sets of channels, following a path through them, and adding up the results. Event classes are
// looked up beforehand, as an integrator does once per kind of event. display/bench/bench_services.cpp adds the cost of
// the state vector of Law 5.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lpe/adopt/channel_set.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/bench/sets.h"
#include "lpe/program.h"
#include "lpe/reversal.h"
#include "lpe/shipped.h"

namespace {

using namespace raylex::lpe;
using namespace raylex::lpe::bench;

std::vector<EventClass> event_classes(const Program& program, const std::vector<RandomPath>& paths) {
    std::vector<EventClass> events;
    for (const RandomPath& path : paths) {
        for (const Event& event : path.events) { events.push_back(program.classify(event)); }
    }
    return events;
}

void report(benchmark::State& state, const Program& program, std::size_t events) {
    const double total = static_cast<double>(state.iterations()) * static_cast<double>(events);
    state.counters["time/event"] = benchmark::Counter(total, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["words"] = static_cast<double>(program.word_count());
    state.counters["states"] = static_cast<double>(program.state_count());
    state.counters["KiB"] = static_cast<double>(program.tables().bytes()) / 1024;
}

void follow(benchmark::State& state, const std::string& set) {
    const Program program = compile_or_exit(named_set(set, static_cast<std::size_t>(state.range(0))));
    const std::vector<EventClass> events = event_classes(program, random_paths(4096));
    const EventClass camera = events.front();
    const ProgramView& view = program.view();
    if (view.word_count == 1) {
        const State start = program.starts()[0];
        for (auto _ : state) {
            State at = start;
            for (const EventClass event : events) {
                at = view.next(event == camera ? start : at, event);
                benchmark::DoNotOptimize(at);
            }
        }
    } else {
        std::vector<State> at(view.word_count);
        for (auto _ : state) {
            for (const EventClass event : events) {
                for (std::size_t word = 0; event == camera && word < at.size(); ++word) {
                    at[word] = view.starts[word];
                }
                benchmark::DoNotOptimize(view.advance(at.data(), event, at.data()));
            }
        }
    }
    report(state, program, events.size());
}

/// Adds a colour to the layers of every channel that accepts a finished path; about 4.5 of 32 channels accept.
void accumulate(benchmark::State& state, const std::string& set) {
    const auto channels = named_set(set, static_cast<std::size_t>(state.range(0)));
    const Program program = compile_or_exit(channels);
    const std::size_t words = program.word_count();
    std::vector<State> ends;
    std::size_t matches = 0, paths = 0;
    for (const RandomPath& path : random_paths(4096)) {
        std::vector<State> at(program.starts().begin(), program.starts().end());
        for (const Event& event : path.events) { program.advance(at.data(), program.classify(event), at.data()); }
        std::size_t accepting = 0;
        program.for_each_accepted(at.data(), [&](std::uint16_t) { ++accepting; });
        matches += accepting;
        ++paths;
        ends.insert(ends.end(), at.begin(), at.end());
    }
    struct alignas(16) Layer {
        std::array<float, 4> rgba{};
    };
    std::vector<Layer> layers(channels.size());
    const Layer colour{{0.25F, 0.5F, 0.75F, 1.0F}};
    for (auto _ : state) {
        for (std::size_t k = 0; k < paths; ++k) {
            program.for_each_accepted(&ends[k * words], [&](std::uint16_t channel) {
                for (std::size_t c = 0; c < 4; ++c) { layers[channel].rgba[c] += colour.rgba[c]; }
            });
            benchmark::ClobberMemory();
        }
    }
    report(state, program, paths);
    state.counters["channels"] = static_cast<double>(matches) / static_cast<double>(paths);
}

void compile(benchmark::State& state, const std::string& set) {
    const auto channels = named_set(set, static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) { benchmark::DoNotOptimize(compile_or_exit(channels)); }
}

void compile_generated(benchmark::State& state) {
    const auto channels = generated_split();
    for (auto _ : state) {
        const Program program = compile_or_exit(channels);
        state.counters["channels"] = static_cast<double>(channels.size());
        state.counters["states"] = static_cast<double>(program.state_count());
        state.counters["KiB"] = static_cast<double>(program.tables().bytes()) / 1024;
    }
}

/// Adds one channel with a new label to a compiled set.
void add_one(benchmark::State& state, const std::string& set) {
    const auto channels = named_set(set, static_cast<std::size_t>(state.range(0)));
    ChannelSource one;
    one.name = "one more";
    one.expression = "C<RD'another object'>[DGS]*L";
    one.dialect = Dialect::osl;
    for (auto _ : state) {
        state.PauseTiming();
        ChannelSet grown;
        if (!grown.add(channels)) {
            state.SkipWithError("the set did not compile");
            return;
        }
        state.ResumeTiming();
        benchmark::DoNotOptimize(grown.add({&one, 1}));
        state.counters["regroupings"] = static_cast<double>(grown.regroupings());
    }
}

/// Looks up the class of a labelled event, as a renderer does once per material.
void classify(benchmark::State& state, const std::string& set) {
    const Program program = compile_or_exit(named_set(set, static_cast<std::size_t>(state.range(0))));
    std::vector<Event> events;
    for (const RandomPath& path : random_paths(64)) {
        events.insert(events.end(), path.events.begin(), path.events.end());
    }
    for (auto _ : state) {
        for (const Event& event : events) { benchmark::DoNotOptimize(program.classify(event)); }
    }
    report(state, program, events.size());
}

void reverse_build(benchmark::State& state, const std::string& set) {
    const Program program = compile_or_exit(named_set(set, static_cast<std::size_t>(state.range(0))));
    for (auto _ : state) {
        const auto reversed = ReversedProgram::build(program);
        if (!reversed) {
            state.SkipWithError(reversed.error().message.c_str());
            return;
        }
        state.counters["KiB"] = static_cast<double>(reversed->bytes()) / 1024;
    }
}

/// Grows a light subpath of `range(1)` scatterings and connects each of its ends once to a camera subpath. The time is
/// that of one vertex and its connection.
void join(benchmark::State& state, const std::string& set) {
    const Program program = compile_or_exit(named_set(set, static_cast<std::size_t>(state.range(0))));
    const auto depth = static_cast<std::size_t>(state.range(1));
    const auto reversed = ReversedProgram::build(program);
    if (!reversed) {
        state.SkipWithError(reversed.error().message.c_str());
        return;
    }
    const auto paths = random_paths(512);
    std::vector<EventClass> scattering, terminals;
    std::vector<State> cameras;
    for (const RandomPath& path : paths) {
        std::vector<State> camera(program.starts().begin(), program.starts().end());
        for (std::size_t k = 0; k < 2; ++k) {
            program.advance(camera.data(), program.classify(path.events[k]), camera.data());
        }
        cameras.insert(cameras.end(), camera.begin(), camera.end());
        scattering.push_back(program.classify(path.events[1]));
        terminals.push_back(program.classify(path.events.back()));
    }
    std::vector<State> light(reversed->word_count()), whole(program.word_count());
    std::size_t accepted = 0;
    for (auto _ : state) {
        for (std::size_t path = 0; path < paths.size(); ++path) {
            const State* camera = &cameras[path * program.word_count()];
            std::copy(reversed->starts().begin(), reversed->starts().end(), light.begin());
            for (std::size_t k = 0; k <= depth; ++k) {
                const EventClass event = k == 0 ? terminals[path] : scattering[(path + k) % paths.size()];
                reversed->prepend(light.data(), event, light.data());
                accepted += reversed->connect(camera, light.data(), whole.data());
            }
        }
    }
    benchmark::DoNotOptimize(accepted);
    report(state, program, paths.size() * (depth + 1));
}

void prove(benchmark::State& state, const std::vector<ChannelSource>& channels) {
    for (auto _ : state) {
        const auto report = check_partition(channels);
        if (!report || report->result != SplitProof::partition) {
            state.SkipWithError(report ? report->summary.c_str() : report.error().message.c_str());
            return;
        }
    }
}

void prove_generated(benchmark::State& state) {
    prove(state, generated_split());
}

void prove_shipped(benchmark::State& state) {
    std::vector<ChannelSource> channels;
    for (const NamedExpression& entry : shipped_partition()) {
        ChannelSource channel;
        channel.name = entry.name;
        channel.expression = entry.expression;
        channels.push_back(std::move(channel));
    }
    prove(state, channels);
}

}  // namespace

BENCHMARK_CAPTURE(follow, firsthit, "firsthit")->Arg(1)->Arg(8)->Arg(32)->Arg(64)->Arg(128);
BENCHMARK_CAPTURE(follow, anywhere, "anywhere")->Arg(64)->Arg(128);
BENCHMARK_CAPTURE(follow, labels, "labels")->Arg(32)->Arg(128)->Arg(512);
BENCHMARK_CAPTURE(follow, mixture, "mixture")->Arg(128)->Arg(256);
BENCHMARK_CAPTURE(accumulate, firsthit, "firsthit")->Arg(32)->Arg(64)->Arg(128);
BENCHMARK_CAPTURE(accumulate, labels, "labels")->Arg(128);
BENCHMARK_CAPTURE(compile, firsthit, "firsthit")
    ->Arg(1)
    ->Arg(8)
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile, anywhere, "anywhere")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile, labels, "labels")->Arg(128)->Arg(512)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile, mixture, "mixture")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(add_one, firsthit, "firsthit")->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(add_one, mixture, "mixture")->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(classify, firsthit, "firsthit")->Arg(128);
BENCHMARK_CAPTURE(reverse_build, firsthit, "firsthit")->Arg(32)->Arg(64)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(join, firsthit, "firsthit")->Args({64, 2})->Args({64, 8})->Args({64, 32});
BENCHMARK_CAPTURE(join, labels, "labels")->Args({128, 8});
BENCHMARK(compile_generated)->Unit(benchmark::kMillisecond);
BENCHMARK(prove_shipped)->Unit(benchmark::kMillisecond);
BENCHMARK(prove_generated)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
