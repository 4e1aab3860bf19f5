// Measures the overhead of writing an image over its encoders: `bench_exr [WIDTH HEIGHT LAYERS ROUNDS]`, by default 960
// 540 64 3.
//
// A: the library's encoders alone, into memory, on planes that are already resolved. B: write_exr() of the frame
// buffer, with resolving, rounding, checking one partition of all layers, writing to disk and syncing. A and B
// alternate. It measures wall time and CPU time of the process; "beyond" is B's wall time over A's CPU time /
// processors.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/output/writer/exr_header.h"
#include "display/output/writer/exr_pixels.h"
#include "display/output/writer/exr_writer.h"

namespace {

using namespace raylex::display;

struct Time {
    double wall = 0, cpu = 0;
};

Time now() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return {std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
            seconds(usage.ru_utime) + seconds(usage.ru_stime)};
}

template <class Action>
Time timed(Action action) {
    const Time begin = now();
    action();
    const Time end = now();
    return {end.wall - begin.wall, end.cpu - begin.cpu};
}

class MemoryStream : public Imf::OStream {
  public:
    MemoryStream() : Imf::OStream("memory") {}
    void write(const char bytes[], int count) override {
        bytes_.resize(std::max(bytes_.size(), position_ + static_cast<std::size_t>(count)));
        std::copy_n(bytes, count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
        position_ += static_cast<std::size_t>(count);
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }

  private:
    std::vector<char> bytes_;
    std::size_t position_ = 0;
};

std::vector<ChannelDefinition> channels(int layers) {
    std::vector<ChannelDefinition> list(static_cast<std::size_t>(layers) + 1);
    for (std::size_t i = 0; i < list.size(); ++i) {
        list[i].name = i == 0 ? "beauty" : "layer" + std::to_string(i);
        list[i].style = ChannelStyle::expression;
    }
    return list;
}

/// Fills two of three layers with noise around a gradient, and leaves the others empty.
void fill(FrameBuffer& buffer, const std::vector<ChannelDefinition>& list, int width, int height) {
    std::vector<CameraRow> rows(static_cast<std::size_t>(width));
    SampleTable table(list, width);
    std::uint32_t random = 1;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            rows[static_cast<std::size_t>(x)].pixel_x = x;
            rows[static_cast<std::size_t>(x)].pixel_y = y;
        }
        table.begin(rows);
        for (ChannelId id = 0; id < table.channel_count(); ++id) {
            if (id % 3 == 2) continue;
            table.touch(id);
            for (int i = 0; i < 3 * width; ++i) {
                random = random * 1664525u + 1013904223u;
                table.raw_values(id)[i] = (1.0 + i) / width + 0.3 * static_cast<double>(random) * 0x1p-32;
            }
        }
        buffer.accumulate(table);
    }
}

}  // namespace

int main(int count, char** arguments) {
    const auto number = [&](int i, int fallback) { return count > i ? std::atoi(arguments[i]) : fallback; };
    const int width = number(1, 960), height = number(2, 540), layers = number(3, 64), rounds = number(4, 3);
    const std::vector<ChannelDefinition> list = channels(layers);
    FrameBuffer buffer({width, height}, list);
    fill(buffer, list, width, height);
    ImageDescription description;
    PartitionDeclaration& partition = description.partitions.emplace_back();
    partition.name = "all";
    for (int i = 1; i <= layers; ++i) partition.layers.push_back(list[static_cast<std::size_t>(i)].name);

    const std::vector<PlannedPart> parts = plan_parts(list, 0, description);
    std::vector<PartPixels> pixels;
    const Time resolving = timed([&] {
        for (const PlannedPart& part : parts) pixels.push_back(part_pixels(buffer, part, true));
    });
    start_encoder_threads();
    std::vector<Imf::Header> headers;
    for (const PlannedPart& part : parts) headers.push_back(make_header(part, buffer.layout(), description));
    const auto encode = [&] {
        MemoryStream stream;
        Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()));
        for (std::size_t i = 0; i < parts.size(); ++i) {
            Imf::FrameBuffer planes;
            for (std::size_t p = 0; p < parts[i].planes.size(); ++p)
                planes.insert(parts[i].planes[p], Imf::Slice(Imf::FLOAT, pixels[i].planes[p].data(), 4,
                                                             4 * static_cast<std::size_t>(width)));
            Imf::OutputPart output(file, static_cast<int>(i));
            output.setFrameBuffer(planes);
            output.writePixels(height);
        }
    };
    const std::string path = (std::filesystem::temp_directory_path() / "raylex_bench.exr").string();
    const double cores = std::thread::hardware_concurrency();
    std::printf("%dx%d, %d layers, %.0f processors; resolving alone %.2f s CPU\n", width, height, layers, cores,
                resolving.cpu);
    Time a, b;
    for (int round = 0; round < rounds; ++round) {
        const Time encoders = timed(encode);
        const Time whole = timed([&] {
            if (auto status = write_exr(path, buffer, 0, description); !status) {
                std::fprintf(stderr, "%s\n", status.error().to_string().c_str());
                std::exit(2);
            }
        });
        std::printf("encoders %.2f s wall %.2f s CPU, write_exr %.2f s wall %.2f s CPU\n", encoders.wall, encoders.cpu,
                    whole.wall, whole.cpu);
        a = {a.wall + encoders.wall, a.cpu + encoders.cpu};
        b = {b.wall + whole.wall, b.cpu + whole.cpu};
    }
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    std::printf("beyond the encoders: CPU %+.1f %%, wall over CPU / processors %+.1f %%\n", 100 * (b.cpu / a.cpu - 1),
                100 * (b.wall / (a.cpu / cores) - 1));
}
