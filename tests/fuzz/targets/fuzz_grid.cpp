// Any bytes as a NanoVDB file: what is read lies within its cells, all of it numbers.
#include <cmath>

#include "tests/fuzz/fuzz.h"
#include "transport/files/nanovdb_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace raylex::transport;
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const auto names = nanovdb_grid_names(file.path());
    if (!names) {
        fuzz::require(!names.error().message.empty(), "a refusal says why");
        return 0;
    }
    for (const std::string& name : *names) {
        const auto grid = read_nanovdb_grid(file.path(), name, false);
        if (!grid) {
            fuzz::require(!grid.error().message.empty(), "a refusal says why");
            continue;
        }
        fuzz::require(grid->has_value(), "a grid that is listed is found");
        const VoxelGrid& values = (*grid)->values;
        fuzz::require(values.box().count() > 0, "there are cells");
        for (std::size_t cell = 0; cell < values.box().count(); ++cell) {
            const CellBounds bounds = values.bounds(cell);
            const Real middle = values.real(cell, {Real(0.5), Real(0.5), Real(0.5)});
            fuzz::require(bounds.least >= 0 && bounds.least <= bounds.most && std::isfinite(bounds.most),
                          "bounds are numbers, in their order");
            fuzz::require(std::isfinite(middle), "values are numbers");
        }
    }
    return 0;
}
