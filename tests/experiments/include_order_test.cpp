// Dependencies run one way. The test reads the includes of the sources.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

using Folders = std::vector<std::string>;

/// Each folder may include those before it. A file belongs to the longest listed folder, so all folders below `lpe` are
/// one and those below `experiments` are separate.
const Folders order = {"lpe",
                       "display",
                       "geoaovs",
                       "transport/math",
                       "transport/color",
                       "transport/samplers",
                       "transport/files",
                       "transport/scene",
                       "transport/geometry",
                       "transport/textures",
                       "transport/embree",
                       "transport/media",
                       "transport/materials",
                       "transport/lights",
                       "transport/cameras",
                       "transport/paths",
                       "transport/integrators",
                       "transport/import",
                       "transport/render",
                       "transport/plugins",
                       "transport",
                       "experiments/revision.h",  // written by the build
                       "experiments/plugins",
                       "experiments/program",
                       "experiments/verify",
                       "experiments/job/text",
                       "experiments/job",
                       "experiments/job/channels",
                       "experiments/job/passes",
                       "experiments/job/rendering",
                       "experiments/mix",
                       "experiments/inspect",
                       "experiments/atlas",
                       "experiments/report",
                       "experiments/shards",
                       "experiments/study",
                       "experiments/study/plan",
                       "experiments/study/run/processes",
                       "experiments/study/run/cells",
                       "experiments/study/run/workers",
                       "experiments/study/run",
                       "experiments/study/analysis",
                       "experiments/study/report",
                       "experiments/study/report/measures",
                       "experiments/study/report/page",
                       "experiments/study/report/paper",
                       "experiments/study/report/study_report.cpp",
                       "experiments/propose",
                       "experiments/cluster",
                       "experiments/invariants",
                       "experiments/stability/suite/formula.h",
                       "experiments/stability",
                       "experiments/stability/suite",
                       "experiments/templates",
                       "experiments/cli",
                       "experiments/cli/render",
                       "experiments/cli/images",
                       "experiments/cli/studies",
                       "experiments/cli/scenes",
                       "experiments/cli/lpe",
                       "experiments"};

/// The order inside folders with subfolders, each list separately. Files beside the folders that begin and end a chain
/// (render.h, render.cpp) are not checked.
const std::vector<Folders> inside = {
    {"lpe/language", "lpe/language/parser"},
    {"lpe/algebra/proofs", "lpe/algebra/wording", "lpe/algebra/explanation", "lpe/algebra/graphs"},
    {"display/services", "display/services/samples", "display/services/liveness"},
    {"display/buffer", "display/buffer/frame_buffer", "display/buffer/sinks", "display/buffer/adaptive"},
    {"display/output", "display/output/color", "display/output/metrics", "display/output/reader",
     "display/output/splits", "display/output/writer", "display/output/denoise", "display/output/atlas",
     "display/output/comparison"},
    {"transport/files", "transport/files/images"},
    {"transport/scene", "transport/scene/effects"},
    {"transport/geometry", "transport/geometry/shapes"},
    {"transport/materials/bsdf", "transport/materials/closures", "transport/materials"},
    {"transport/lights/images", "transport/lights"},
    {"transport/import/shapes", "transport/import", "transport/import/builder", "transport/import/pbrt"},
    {"transport/paths", "transport/paths/subpaths"},
    {"transport/render/resolve", "transport/render/pilots", "transport/render/stages", "transport/render/schedules",
     "transport/render/loop"},
    {"experiments/python/bindings", "experiments/python/bindings/plugins"},
};

/// Returns the position in an order of a file by its path from the root; -1 if it is in none of the folders.
int place_of(const Folders& folders, const std::string& file) {
    int place = -1;
    std::size_t longest = 0;
    for (std::size_t i = 0; i < folders.size(); ++i) {
        const std::string& folder = folders[i];
        if (folder.size() <= longest || (file != folder && !file.starts_with(folder + "/"))) continue;
        longest = folder.size();
        place = static_cast<int>(i);
    }
    return place;
}

/// Returns the first include of `file` that comes later in the order; "" if there is none, or if the file is in none of
/// the folders.
std::string include_out_of_order(const Folders& folders, const fs::path& root, const std::string& file) {
    if (place_of(folders, file) < 0) return {};
    std::ifstream in(root / file);
    const std::string opening = "#include \"";
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with(opening)) continue;
        const std::string included = line.substr(opening.size(), line.find('"', opening.size()) - opening.size());
        if (place_of(folders, included) > place_of(folders, file)) return file + " includes " + included;
    }
    return {};
}

}  // namespace

TEST_CASE("a folder includes nothing from a folder above it", "[layout]") {
    const fs::path root = raylex::test::source_dir();
    std::size_t files = 0;
    for (const char* top : {"lpe", "display", "geoaovs", "transport", "experiments"}) {
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp") continue;
            ++files;
            const std::string file = fs::relative(entry.path(), root).string();
            CHECK(include_out_of_order(order, root, file) == "");
            for (const Folders& folders : inside) CHECK(include_out_of_order(folders, root, file) == "");
        }
    }
    CHECK(files > 400);
}

TEST_CASE("integrators do not depend on the requested channels", "[layout]") {
    // Liveness, pruning, pilots and the shares of techniques belong to paths/ and render/. Lobes of the field's prose,
    // such as "exact shares" of lobes, are not code and do not count.
    const std::regex banned(
        R"(\b(is_live\w*|LiveLights|live_lights|Pruned|prunes|[Pp]ilot\w*|TechniqueShares|\w+_share|liveness)\b)");
    const fs::path root = raylex::test::source_dir();
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(root / "transport/integrators")) {
        if (!entry.is_regular_file()) continue;
        ++files;
        std::ifstream in(entry.path());
        std::size_t number = 0;
        for (std::string line; std::getline(in, line);) {
            ++number;
            CAPTURE(entry.path().filename().string(), number, line);
            CHECK_FALSE(std::regex_search(line, banned));
        }
    }
    CHECK(files > 10);
}
