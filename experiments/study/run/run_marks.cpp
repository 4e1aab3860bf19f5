#include "experiments/study/run/run_marks.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "display/output/atomic_file.h"
#include "experiments/job/text/json_fields.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {

static void visit_fields(auto visit, RunMark& mark) {
    visit("config", mark.config_hash);
    visit("shard", mark.shard.part);
    visit("shards", mark.shard.parts);
    visit("split_cells", mark.shard.split_runs);
    visit("only_references", mark.only_references);
    visit("done", mark.done);
    visit("failed", mark.failed);
}

namespace {

namespace fs = std::filesystem;

constexpr std::array mark_names{"begun.json", "finished.json", "error.txt"};

std::string mark_text(const RunMark& mark) {
    return json_text(mark) + "\n";
}

std::optional<RunMark> read_mark(const std::string& path) {
    std::error_code failed;
    if (!fs::exists(path, failed)) return std::nullopt;
    const auto json = read_json_file(path, "a mark of a run");
    if (!json) return std::nullopt;
    try {
        return json->get<RunMark>();
    } catch (const std::exception&) { return std::nullopt; }
}

}  // namespace

std::string finished_file(const std::string& directory) {
    return directory + "/finished.json";
}

bool is_run_mark(const std::string& name) {
    return std::find(mark_names.begin(), mark_names.end(), name) != mark_names.end();
}

Status mark_begun(const std::string& directory, const RunMark& mark) {
    std::error_code failed;
    fs::create_directories(directory, failed);
    if (failed) return error_at({directory, 0, 0}, "cannot make this directory: " + failed.message());
    for (const char* old : {"finished.json", "error.txt"})
        if (Status s = display::remove_file(directory + "/" + old); !s) return s;
    return display::write_text_file(directory + "/begun.json", mark_text(mark));
}

Status mark_finished(const std::string& directory, const RunMark& mark) {
    return display::write_text_file(finished_file(directory), mark_text(mark));
}

void mark_error(const std::string& directory, const Error& error) {
    static_cast<void>(display::write_text_file(directory + "/error.txt", error.to_string() + "\n"));
}

std::optional<RunMark> begun_mark(const std::string& directory) {
    return read_mark(directory + "/begun.json");
}

std::optional<RunMark> finished_mark(const std::string& directory) {
    return read_mark(finished_file(directory));
}

bool is_done(const std::string& directory) {
    const auto mark = finished_mark(directory);
    return mark && mark->failed == 0;
}

std::string error_mark(const std::string& directory) {
    std::error_code failed;
    if (!fs::exists(directory + "/error.txt", failed)) return {};
    auto text = raylex::read_record(directory + "/error.txt", "an error mark");
    std::string message = text ? *text : text.error().to_string();
    while (!message.empty() && message.back() == '\n') message.pop_back();
    return message.empty() ? "it ended with an error" : message;
}

}  // namespace raylex::experiments
