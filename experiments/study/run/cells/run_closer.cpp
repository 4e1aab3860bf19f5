#include "experiments/study/run/cells/run_closer.h"

#include <pthread.h>
#include <exception>
#include <filesystem>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/services/parameters.h"
#include "display/services/thread_or_none.h"
#include "experiments/study/file_records.h"
#include "experiments/study/results_file.h"
#include "transport/render/clock.h"

namespace raylex::experiments {

namespace fs = std::filesystem;

Status close_run_directory(const WrittenRun& run) {
    auto files = file_records(run.partial);
    if (!files) return files.error();
    StudyRun whole = run.run;
    whole.files = *std::move(files);
    if (Status s = write_run_file(run.partial + "/cell.json", whole, display::FileSync::later); !s) return s;
    if (Status s = display::sync_files_in(run.partial); !s) return s;
    std::error_code ignored, failed;
    for (const std::string& each : run.obsolete) fs::remove(each, ignored);
    fs::rename(run.partial, run.final_name, failed);
    if (!failed) return success();
    return error_at({run.final_name, 0, 0}, "cannot rename the finished directory to this name: " + failed.message());
}

RunCloser::RunCloser() : thread_(display::thread_or_none([this] { work(); })) {
    if (!thread_.joinable() || pthread_getcpuclockid(thread_.native_handle(), &clock_) != 0) clock_ = -1;
}

RunCloser::~RunCloser() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void RunCloser::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return cell_ || ending_; });
        if (!cell_) return;
        lock.unlock();
        Status status = success();
        try {
            status = close_run_directory(*cell_);
        } catch (const std::exception& error) {
            status = error_at({cell_->partial, 0, 0}, std::string("cannot finish this directory: ") + error.what());
        }
        lock.lock();
        status_ = std::move(status);
        cell_.reset();
        changed_.notify_all();
    }
}

Status RunCloser::close(WrittenRun run) {
    if (Status s = wait(); !s || !thread_.joinable()) return s ? close_run_directory(run) : s;
    const std::lock_guard lock(mutex_);
    cell_ = std::move(run);
    changed_.notify_all();
    return success();
}

Status RunCloser::wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !cell_; });
    return std::exchange(status_, success());
}

double RunCloser::cpu_seconds() const {
    return clock_ == -1 ? 0 : transport::cpu_seconds(clock_);
}

}  // namespace raylex::experiments
