#include "lpe/bench/sets.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>

namespace raylex::lpe::bench {

namespace {

ChannelSource channel(std::string expression, Dialect dialect) {
    ChannelSource source;
    source.name = expression;
    source.expression = std::move(expression);
    source.dialect = dialect;
    return source;
}

}  // namespace

std::vector<ChannelSource> file_set(const std::string& name, std::size_t count) {
    std::ifstream file(std::string(RAYLEX_SOURCE_DIR) + "/lpe/bench/data/lpe_bench_" + name + ".txt");
    std::vector<ChannelSource> channels;
    for (std::string line; channels.size() < count && std::getline(file, line);) {
        channels.push_back(channel(line, Dialect::osl));
    }
    if (channels.size() != count) {
        std::cerr << "benchmark set '" << name << "' has fewer than " << count << " expressions\n";
        std::exit(2);
    }
    return channels;
}

std::vector<ChannelSource> anywhere_labels(std::size_t count) {
    std::vector<ChannelSource> channels;
    for (std::size_t k = 0; k < count; ++k) {
        channels.push_back(channel("C.*<RD'object" + std::to_string(k) + "'>.*", Dialect::osl));
    }
    return channels;
}

std::vector<ChannelSource> named_set(const std::string& name, std::size_t count) {
    if (name == "labels") { return anywhere_labels(count); }
    if (name == "mixture") {
        std::vector<ChannelSource> channels = file_set("firsthit", count / 2);
        const std::vector<ChannelSource> labels = anywhere_labels(count - count / 2);
        channels.insert(channels.end(), labels.begin(), labels.end());
        return channels;
    }
    return file_set(name, count);
}

std::vector<ChannelSource> generated_split() {
    std::vector<std::string> lobes{"<R[^D1D2D3D4S1S2S3S4S5S6S7S8]>", "<TD>", "<TS>", "V"};
    for (const auto& [letter, numbers] : {std::pair("D", 4), std::pair("S", 8)}) {
        for (int number = 1; number <= numbers; ++number) {
            lobes.push_back(std::string("<R") + letter + std::to_string(number) + ">");
        }
    }
    std::vector<std::string> lights;
    std::string others;
    for (const char* group : {"key", "fill", "rim", "kick", "practical", "sky", "screen"}) {
        lights.push_back(std::string("<L.'") + group + "'>");
        others += std::string("'") + group + "'";
    }
    lights.push_back("[<L.[^" + others + "]>O]");
    std::vector<ChannelSource> channels{channel("C[<L.>O]", Dialect::renderman)};
    for (const std::string& light : lights) {
        for (const std::string& lobe : lobes) {
            for (const char* bounces : {"", "[RTV]", "[RTV]{2}", "[RTV]{3,}"}) {
                channels.push_back(channel("C" + lobe + bounces + light, Dialect::renderman));
            }
        }
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

std::vector<RandomPath> random_paths(std::size_t count) {
    const std::vector<std::string> objects{"floor", "wall", "hero", "glass", "skin", "object3", "object77", ""};
    const std::vector<std::string> lights{"key", "fill", "rim", "env", ""};
    Random random;
    std::vector<RandomPath> paths(count);
    for (RandomPath& path : paths) {
        path.events.push_back({EventType::camera, Scatter::none, 0, {}});
        for (std::size_t length = 1 + random.below(6); length > 0; --length) {
            const EventType type = random.below(3) == 0 ? EventType::transmission : EventType::reflection;
            const Scatter scatter = static_cast<Scatter>(1 + random.below(3));
            path.events.push_back({type, scatter, 0, {objects[random.below(objects.size())], ""}});
        }
        path.events.push_back({EventType::light, Scatter::none, 0, {lights[random.below(lights.size())]}});
    }
    return paths;
}

}  // namespace raylex::lpe::bench
