// Light found later on a path is added to the vertices that the path passed.
#include "transport/paths/plan/later_radiance.h"
#include "transport/render_support.h"

using namespace render_test;
using transport::LaterRadiance;
using transport::PassedVertex;

namespace {

/// A table of one expression channel, whose rows receive grey light.
struct Table {
    std::vector<display::ChannelDefinition> channels{lpe_channel("c", "C.*L")};
    display::SampleTable table{channels, 4};
    LaterRadiance later{table, {0}};

    Table() {
        const std::vector<display::CameraRow> rows(4);
        table.begin(rows);
        later.begin();
    }
    void pass(std::uint32_t row, std::uint32_t depth) {
        PassedVertex vertex;
        vertex.row = row;
        vertex.depth = depth;
        later.pass(vertex);
    }
    void find(int row, double light) {
        for (double& value : table.edit(0, row)) value += light;
    }
    /// What was found behind each vertex of a row.
    std::vector<double> behind(std::size_t row) {
        std::vector<double> found;
        later.end(4, [&](std::size_t at, const LaterRadiance::Path& path) {
            for (std::size_t i = 0; at == row && i < path.vertices.size(); ++i) found.push_back(path.behind(i, 0));
        });
        return found;
    }
};

}  // namespace

TEST_CASE("light found later counts for all vertices that the path passed before", "[later]") {
    Table t;
    t.find(1, 1);  // seen directly
    t.pass(1, 1);
    t.pass(2, 1);
    t.find(1, 2);
    t.pass(1, 2);
    t.find(2, 64);
    t.find(1, 4);
    CHECK(t.behind(1) == std::vector<double>{6, 4});
    CHECK(t.behind(2) == std::vector<double>{64});
    CHECK(t.behind(0).empty());
    t.later.end(4, [&](std::size_t row, const LaterRadiance::Path& path) {
        CHECK(path.received[0] == (row == 1 ? 7 : row == 2 ? 64 : 0));
        if (row == 1) CHECK(path.before(1, 0) == 3);
    });
    t.later.begin();
    CHECK(t.behind(1).empty());
}

TEST_CASE("each ray of a split vertex has the light that it leads to, and vertices before have all of it", "[later]") {
    Table t;
    t.pass(0, 1);
    t.pass(0, 2);  // the first ray of a split
    t.find(0, 1);
    t.pass(0, 3);
    t.find(0, 2);
    t.pass(0, 2);  // the second
    t.pass(0, 3);
    t.find(0, 4);
    CHECK(t.behind(0) == std::vector<double>{7, 3, 2, 4, 4});
}
