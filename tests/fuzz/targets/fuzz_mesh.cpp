// Any bytes as a PLY file, gzip-compressed or not: what is read has its indices in range and as many normals as
// positions.
#include <algorithm>

#include "tests/fuzz/fuzz.h"
#include "transport/files/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const auto mesh = raylex::transport::read_ply(file.path());
    if (!mesh) {
        fuzz::require(!mesh.error().message.empty(), "a refusal says why");
        return 0;
    }
    const std::size_t count = mesh->positions.size();
    const auto in_range = [count](std::uint32_t index) { return index < count; };
    fuzz::require(std::all_of(mesh->triangles.begin(), mesh->triangles.end(), in_range), "triangles are in range");
    fuzz::require(std::all_of(mesh->quads.begin(), mesh->quads.end(), in_range), "quads are in range");
    fuzz::require(mesh->triangles.size() % 3 == 0 && mesh->quads.size() % 4 == 0, "faces are whole");
    fuzz::require(mesh->normals.empty() || mesh->normals.size() == count, "one normal a position");
    return 0;
}
