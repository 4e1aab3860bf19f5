#include <sys/mman.h>
#include <unistd.h>

#include "tests/fuzz/fuzz.h"

namespace fuzz {

MemoryFile::MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(memfd_create("fuzzed", MFD_CLOEXEC)) {
    require(descriptor_ >= 0, "a file in memory can be made");
    require(write(descriptor_, data, size) == static_cast<ssize_t>(size), "a file in memory can be written");
}

MemoryFile::~MemoryFile() {
    close(descriptor_);
}

}  // namespace fuzz
