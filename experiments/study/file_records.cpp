#include "experiments/study/file_records.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "display/services/hash64.h"
#include "display/services/parameters.h"
#include "experiments/study/results_json.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Maps the file instead of reading it: the pages of a newly written file are in memory, and need no copy.
Result<FileRecord> record_of(const std::string& path) {
    const auto fails = [&] {
        return error_at({path, 0, 0}, "cannot read this file: " + std::string(std::strerror(errno)));
    };
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return fails();
    struct stat status {};
    if (fstat(file, &status) != 0) {
        close(file);
        return fails();
    }
    const auto size = static_cast<std::size_t>(status.st_size);
    FileRecord record{fs::path(path).filename().string(), size, {}};
    void* const bytes = size == 0 ? nullptr : mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (bytes == MAP_FAILED) return fails();
    record.hash = hash_text(hash64({static_cast<const char*>(bytes), size}));
    if (bytes != nullptr) munmap(bytes, size);
    return record;
}

bool is_listed(const std::string& name) {
    return name != "cell.json" && name != "reference.json" && name.find(".checkpoint") == std::string::npos;
}

}  // namespace

Result<std::vector<FileRecord>> file_records(const std::string& directory) {
    std::vector<std::string> paths;
    std::error_code failed;
    for (const fs::directory_entry& each : fs::directory_iterator(directory, failed))
        if (each.is_regular_file(failed) && is_listed(each.path().filename().string()))
            paths.push_back(each.path().string());
    std::sort(paths.begin(), paths.end());
    std::vector<FileRecord> records;
    for (const std::string& path : paths) {
        auto record = record_of(path);
        if (!record) return record.error();
        records.push_back(*std::move(record));
    }
    return records;
}

std::string damage_of(const std::string& directory, const std::vector<FileRecord>& files) {
    for (const FileRecord& wanted : files) {
        const std::string path = directory + "/" + wanted.name;
        std::error_code failed;
        if (!fs::exists(path, failed)) return path + ": this file is missing";
        const std::uintmax_t size = fs::file_size(path, failed);
        if (!failed && size != wanted.bytes)
            return path + ": this file has " + std::to_string(size) + " bytes; it was written with " +
                   std::to_string(wanted.bytes);
        auto found = record_of(path);
        if (!found) return found.error().to_string();
        if (found->hash != wanted.hash)
            return path + ": this file has changed: hash " + found->hash + ", expected " + wanted.hash;
    }
    return {};
}

std::string damage_of(const StudyRun& run) {
    return run.failed ? std::string() : damage_of(run.directory, run.files);
}

std::string damage_of_reference(const std::string& directory) {
    const std::string path = directory + "/reference.json";
    if (std::error_code failed; !fs::exists(path, failed)) return path + ": this file is missing";
    const Result<Json> json = read_json_file(path, "a reference.json");
    if (!json) return json.error().to_string();
    try {
        std::vector<FileRecord> files;
        for (const auto& each : json->value("files", Json::array())) files.push_back(each.get<FileRecord>());
        return damage_of(directory, files);
    } catch (const Json::exception& error) { return path + ": this is damaged: " + error.what(); }
}

}  // namespace raylex::experiments
