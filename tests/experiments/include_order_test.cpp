// Dependencies run one way: what the folders of the tree include is read from their sources.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

/// Each may include what stands before it. A folder goes by its longest name here, so that those below `lpe` are one
/// and those below `experiments` are not.
const char* const order[] = {"lpe",
                             "display",
                             "geoaovs",
                             "transport",
                             "experiments/revision.h",  // written by the build
                             "experiments/plugins",
                             "experiments/program",
                             "experiments/verify",
                             "experiments/job",
                             "experiments/inspect",
                             "experiments/atlas",
                             "experiments/report",
                             "experiments/shards",
                             "experiments/study",
                             "experiments/study/plan",
                             "experiments/study/run",
                             "experiments/study/analysis",
                             "experiments/study/report",
                             "experiments/cluster",
                             "experiments/invariants",
                             "experiments/stability/suite/formula.h",
                             "experiments/stability",
                             "experiments/stability/suite",
                             "experiments/stability/probes",
                             "experiments/cli",
                             "experiments/cli/lpe",
                             "experiments"};

/// The place in that order of a file by its path from the root; -1: it is in none of the folders.
int place_of(const std::string& file) {
    int place = -1;
    std::size_t longest = 0;
    for (std::size_t i = 0; i < std::size(order); ++i) {
        const std::string folder = order[i];
        if (folder.size() <= longest || (file != folder && !file.starts_with(folder + "/"))) continue;
        longest = folder.size();
        place = static_cast<int>(i);
    }
    return place;
}

/// "" where all that `file` includes stands before it; else the include that does not.
std::string include_out_of_order(const fs::path& root, const std::string& file) {
    std::ifstream in(root / file);
    const std::string opening = "#include \"";
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with(opening)) continue;
        const std::string included = line.substr(opening.size(), line.find('"', opening.size()) - opening.size());
        if (place_of(included) > place_of(file)) return file + " includes " + included;
    }
    return {};
}

}  // namespace

TEST_CASE("a folder includes nothing that stands above it", "[layout]") {
    const fs::path root = raylex::test::source_dir();
    std::size_t files = 0;
    for (const char* top : {"lpe", "display", "geoaovs", "transport", "experiments"}) {
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp") continue;
            ++files;
            CHECK(include_out_of_order(root, fs::relative(entry.path(), root).string()) == "");
        }
    }
    CHECK(files > 400);
}
