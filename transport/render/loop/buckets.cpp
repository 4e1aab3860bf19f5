#include "transport/render/loop/buckets.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "display/output/writer/exr_writer.h"
#include "transport/render/loop/render_output.h"
#include "transport/render/resolve/resolve_checks.h"

namespace raylex::transport {
namespace {

namespace fs = std::filesystem;
using display::RowRange;

/// The current resident memory of this process.
std::uint64_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t size = 0, resident = 0;
    file >> size >> resident;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// The memory for one row of the image, rendered and saved, and the memory that does not depend on buckets.
struct BucketMemory {
    std::uint64_t row = 0, scene = 0, writer = 0, threads = 0;
    [[nodiscard]] std::uint64_t beside() const { return scene + writer + threads; }
};

BucketMemory bucket_memory(const ResolvedJob& job) {
    BucketMemory memory;
    display::FrameBufferLayout layout = layout_of(job);
    layout.height = 1;
    const auto width = static_cast<std::uint64_t>(layout.width);
    // The record, and its packed bytes, which are usually fewer. While writing: two layers, as double and in the file's
    // format, and the sums of a split.
    constexpr std::uint64_t written_pixel = 200;
    memory.row =
        2 * display::total_bytes(display::frame_buffer_memory(layout, job.channels.list)) + written_pixel * width;
    memory.scene = resident_bytes();
    memory.writer = display::exr_writing_bytes(job.channels.list, job.channels.beauty, layout.width);
    std::uint64_t components = 0;
    for (const display::ChannelDefinition& channel : job.channels.list)
        components += static_cast<std::uint64_t>(display::component_count(channel.type));
    const auto table_rows = static_cast<std::uint64_t>(RenderWorker::batch_capacity) * (job.has_extra_rows ? 5 : 1);
    constexpr std::uint64_t stacks_and_heap = std::uint64_t{16} << 20;
    memory.threads =
        static_cast<std::uint64_t>(job.threads) * (2 * table_rows * components * sizeof(double)) + 2 * stacks_and_heap;
    return memory;
}

std::string text_of(std::uint64_t bytes) {
    return display::memory_text(bytes);
}

Status check_buckets(const ResolvedJob& job) {
    const std::string what = "a render in buckets", without = "--memory and --bucket-rows";
    if (Status s = check_pixels_independent(job.settings.stop, job.sampling.splat, job.chosen, what, without); !s)
        return s;
    if (job.settings.stop.limit)
        return error_at({},
                        what +
                            " with a time limit: all pixels need the same number of samples, which "
                            "is unknown when the first bucket is finished",
                        "expected a number of samples; a time limit is possible without " + without);
    if (!job.settings.mattes.kinds.empty())
        return error_at({}, what + " with cryptomattes, whose names and ranks are kept for the whole image",
                        "leave out the cryptomattes, or render them separately without " + without +
                            ": few samples and no beauty are enough");
    if (job.integrator().starts_up())
        return error_at({}, what + " by integrator '" + job.chosen.name + "', whose paths depend on one another",
                        "leave out " + without + ", or choose another integrator, such as path");
    if (job.integrator().traits().saved_state == SavedState::unknown)
        return error_at({},
                        what + " by integrator '" + job.chosen.name +
                            "', whose state cannot be saved, so that no bucket can be saved",
                        "leave out " + without + ", or choose another integrator, such as path");
    return success();
}

/// The number of rows of a bucket; nothing if the image fits into memory.
Result<std::optional<int>> rows_of(const ResolvedJob& job, bool begun) {
    const BucketSettings& asked = *job.settings.buckets;
    if (asked.memory == 0) return std::optional<int>(asked.rows);
    const BucketMemory memory = bucket_memory(job);
    const std::uint64_t whole = display::total_bytes(plan_of(job).memory);
    if (asked.rows == 0 && !begun && memory.beside() + whole <= asked.memory) return std::optional<int>();
    const std::string need = "the image needs " + text_of(whole) + " beside " + text_of(memory.beside()) +
                             ", but --memory allows " + text_of(asked.memory) + ", ";
    if (Status s = check_buckets(job); !s) {
        Error error = s.error();
        error.message = need + "and " + error.message + " is not possible";
        return error;
    }
    const std::uint64_t left = asked.memory - std::min(asked.memory, memory.beside());
    std::uint64_t rows = left / memory.row;
    constexpr auto tile = static_cast<std::uint64_t>(TileGrid::tile_size);
    if (rows > tile) rows -= rows % tile;
    if (rows == 0)
        return error_at({}, need + "and not even a row of it fits: expected --memory of at least " +
                                text_of(memory.beside() + memory.row) + " (scene and program " + text_of(memory.scene) +
                                ", writing the image " + text_of(memory.writer) + ", threads " +
                                text_of(memory.threads) + ", a row " + text_of(memory.row) + ")");
    rows = std::min<std::uint64_t>(rows, static_cast<std::uint64_t>(job.grid.height));
    if (asked.rows > 0) rows = std::min<std::uint64_t>(rows, static_cast<std::uint64_t>(asked.rows));
    return std::optional<int>(static_cast<int>(rows));
}

/// The rows in a name like "rows-00000-00032.bucket"; nothing for other names.
std::optional<RowRange> rows_named(const fs::path& file) {
    RowRange rows;
    int length = 0;
    const std::string name = file.filename().string();
    if (std::sscanf(name.c_str(), "rows-%5d-%5d.bucket%n", &rows.first, &rows.end, &length) != 2 ||
        static_cast<std::size_t>(length) != name.size())
        return {};
    return rows;
}

/// The rows of the buckets with files in the folder, in order.
Result<std::vector<RowRange>> saved_buckets(const std::string& folder, const RowRange& image) {
    std::vector<RowRange> saved;
    std::error_code failed;
    for (const fs::directory_entry& each : fs::directory_iterator(folder, failed)) {
        const std::optional<RowRange> rows = rows_named(each.path());
        if (!rows) continue;
        if (rows->first < image.first || rows->end > image.end || rows->first >= rows->end)
            return error_at(
                {each.path().string(), 0, 0}, "cannot resume: the bucket contains rows that this render does not have",
                "use the settings of the first session, or, to start again, remove the folder and leave out --resume");
        saved.push_back(*rows);
    }
    if (failed) return error_at({folder, 0, 0}, "cannot read the folder with the buckets: " + failed.message());
    std::sort(saved.begin(), saved.end(), [](const RowRange& a, const RowRange& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < saved.size(); ++i)
        if (saved[i].first < saved[i - 1].end)
            return error_at({folder, 0, 0}, "cannot resume: two buckets have row " + std::to_string(saved[i].first),
                            "one of them belongs to another render: remove it");
    return saved;
}

}  // namespace

std::string BucketPlan::file_of(const RowRange& rows) const {
    std::array<char, 64> name{};
    std::snprintf(name.data(), name.size(), "/rows-%05d-%05d.bucket", rows.first, rows.end);
    return folder + name.data();
}

Result<std::optional<BucketPlan>> plan_buckets(const PreparedJob& prepared) {
    const ResolvedJob& job = prepared.job;
    if (!job.settings.buckets || job.budget.only) return std::optional<BucketPlan>();
    if (!job.checkpoint)
        return error_at({}, "a render in buckets without a folder for them; expected the name of a folder");
    std::error_code failed;
    const bool begun = job.checkpoint->resume && fs::is_directory(job.checkpoint->file, failed);
    const auto rows = rows_of(job, begun);
    if (!rows) return rows.error();
    if (!*rows) return std::optional<BucketPlan>();
    if (Status s = check_buckets(job); !s) return s.error();
    if (job.checkpoint->resume && !begun && fs::exists(job.checkpoint->file, failed))
        return error_at({job.checkpoint->file, 0, 0},
                        "cannot resume: this is the checkpoint of a render without buckets",
                        "leave out --memory and --bucket-rows, or, to start again, remove this file and leave out "
                        "--resume");
    BucketPlan plan;
    plan.folder = job.checkpoint->file;
    const RowRange image{job.grid.region.y0, job.grid.region.y1};
    std::vector<RowRange> saved;
    if (begun) {
        auto found = saved_buckets(plan.folder, image);
        if (!found) return found.error();
        saved = *std::move(found);
    }
    saved.push_back({image.end, image.end});
    int next = image.first;
    for (const RowRange& each : saved) {
        for (const RowRange& missing : display::bands_of({next, each.first}, **rows)) plan.buckets.push_back(missing);
        if (each.first < each.end) plan.buckets.push_back(each);
        next = each.end;
    }
    return std::optional<BucketPlan>(std::move(plan));
}

namespace {

/// Passes the plan to the caller, and makes the folder.
Status begin_buckets(const ResolvedJob& job, const BucketPlan& plan, const display::RecordIdentity& identity) {
    if (job.settings.before_rendering) {
        RenderPlan told = plan_of(job);
        told.identity = identity;
        told.buckets = plan.buckets.size();
        for (const RowRange& rows : plan.buckets) told.bucket_rows = std::max(told.bucket_rows, rows.end - rows.first);
        std::vector<display::SampleSink*> sinks;
        if (Status s = job.settings.before_rendering(told, sinks); !s) return s;
        if (!sinks.empty())
            return error_at(
                {},
                "a render in buckets with an output that reads raw samples of the whole image, such as a deep "
                "image or a path atlas",
                "leave out these, or --memory and --bucket-rows");
    }
    std::error_code failed;
    fs::create_directories(plan.folder, failed);
    if (failed)
        return error_at({plan.folder, 0, 0}, "cannot make the folder for finished buckets: " + failed.message());
    return success();
}

/// Converts the progress of one loop to progress of the whole render.
std::function<void(const RenderProgress&)> of_whole(const ResolvedJob& job, const display::PixelRegion& region,
                                                    const std::function<void(const RenderProgress&)>& progress) {
    const std::uint64_t total = static_cast<std::uint64_t>(region.width()) *
                                static_cast<std::uint64_t>(region.height()) *
                                (job.budget.samples_per_pixel - job.budget.first_sample);
    if (!progress) return {};
    return [&progress, total](const RenderProgress& now) {
        RenderProgress whole = now;
        whole.samples_total = total;
        whole.image = nullptr;
        progress(whole);
    };
}

/// An image that reads the buckets that exist.
std::unique_ptr<const display::BandedImage> image_of(const ResolvedJob& job, const BucketPlan& plan,
                                                     const std::vector<RowRange>& there) {
    display::FrameBufferLayout layout = layout_of(job);
    return std::make_unique<const display::BandedImage>(
        layout, job.channels.list, there, [plan](const RowRange& rows) -> Result<display::FrameBuffer> {
            auto file = display::RecordFileReader::open(plan.file_of(rows));
            if (!file) return file.error();
            const auto bytes = file->read("frame buffer");
            if (!bytes) return bytes.error();
            return display::FrameBuffer::from_record(*bytes);
        });
}

}  // namespace

Result<RenderOutput> render_buckets(PreparedJob& prepared, const BucketPlan& plan, const Stopwatch& since_call,
                                    const std::function<void(const RenderProgress&)>& progress,
                                    const std::atomic<bool>* stop) {
    ResolvedJob& job = prepared.job;
    const display::PixelRegion region = job.grid.region;
    const display::RecordIdentity identity = render_identity(job);  // of the whole image
    const auto report = of_whole(job, region, progress);
    std::optional<RenderOutput> output;
    std::vector<RowRange> there;
    std::uint64_t rejected = 0, resumed = 0, checkpoints = 0;
    double magnitude = 0;
    double stall = 0;
    for (const RowRange& rows : plan.buckets) {
        job.bucket = rows;
        job.grid.region = {region.x0, rows.first, region.x1, rows.end};
        if (&rows == &plan.buckets.front())
            if (Status s = begin_buckets(job, plan, identity); !s) return s.error();
        job.checkpoint->file = plan.file_of(rows);
        display::remove_abandoned(job.checkpoint->file);
        std::error_code failed;
        job.checkpoint->resume = fs::exists(job.checkpoint->file, failed);
        const RenderStatistics earlier = output ? std::move(output->statistics) : RenderStatistics{};
        output.reset();
        auto target = RenderTarget::allocate(prepared, {});
        if (!target) return target.error();
        auto loop = RenderLoop::begin(prepared, *target, since_call, earlier);
        if (!loop) return loop.error();
        const bool was_finished = (*loop)->finished();
        auto finished = (*loop)->run(report, stop);
        if (!finished) return finished.error();
        if (finished->samples.complete && !was_finished)
            if (Status s = (*loop)->keep(); !s) return s.error();
        if (job.checkpoint->resume) resumed = finished->samples.resumed;
        if (fs::exists(job.checkpoint->file, failed)) there.push_back(rows);
        checkpoints += finished->statistics.checkpoints;
        stall += finished->statistics.checkpoint_stall_seconds;
        rejected += target->frame_buffer.rejected_count();
        magnitude = std::max(magnitude, target->frame_buffer.light_magnitude());
        output.emplace(output_of(job, *std::move(target), *std::move(finished)));
        if (!output->samples.complete) break;
    }
    job.bucket.reset();
    job.grid.region = region;
    // The memory of the last bucket is released too, before the image is read.
    display::FrameBufferLayout row = layout_of(job);
    row.height = 1;
    output->frame_buffer = display::FrameBuffer(row, job.channels.list);
    output->buckets.image = image_of(job, plan, there);
    output->buckets.rows = there;
    output->sums = {.rejected = rejected, .light_magnitude = magnitude};
    output->samples.resumed = resumed;
    output->statistics.checkpoints = checkpoints;
    output->statistics.checkpoint_stall_seconds = stall;
    return *std::move(output);
}

Status remove_buckets(const std::string& folder) {
    std::error_code failed;
    std::vector<fs::path> files;
    std::vector<std::string> begun;  // begun by a process that died; this render may divide the image differently
    for (const fs::directory_entry& each : fs::directory_iterator(folder, failed)) {
        const std::string name = each.path().filename().string(), ending = ".bucket";
        if (rows_named(each.path())) files.push_back(each.path());
        else if (const auto end = name.rfind(ending + "."); end != std::string::npos)
            begun.push_back((each.path().parent_path() / name.substr(0, end + ending.size())).string());
    }
    for (const std::string& each : begun) display::remove_abandoned(each);
    for (const fs::path& file : files)
        if (Status removed = display::remove_file(file.string()); !removed) return removed;
    fs::remove(folder, failed);
    if (failed) return error_at({folder, 0, 0}, "the folder of the buckets could not be removed: " + failed.message());
    return success();
}

}  // namespace raylex::transport
