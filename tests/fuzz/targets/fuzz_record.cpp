// Any bytes as a checkpoint.
#include "display/checkpoint/record_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    static_cast<void>(raylex::display::read_record_file(file.path()));
    return 0;
}
