// Any bytes as a NumPy array.
#include "experiments/study/results.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const auto array = raylex::experiments::read_npy(file.path());
    if (array)
        fuzz::require(array->values.size() == array->width * array->height * array->components,
                      "as many as its shape says");
    return 0;
}
