// What the fuzz targets share: a reader that cuts the fuzzer's bytes into choices, and a check that stops the run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace fuzz {

class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    [[nodiscard]] bool empty() const { return size_ == 0; }
    /// A choice below `count`, 0 when the bytes are used up.
    std::size_t below(std::size_t count) {
        if (size_ == 0) return 0;
        --size_;
        return *data_++ % count;
    }
    /// All that is left.
    std::string rest() {
        std::string text(reinterpret_cast<const char*>(data_), size_);
        size_ = 0;
        return text;
    }

  private:
    const std::uint8_t* data_;
    std::size_t size_;
};

/// While it lives, allocations count against the bound of one input (allocation_meter.cpp): for expressions what
/// lpe/limits.h promises, for readers of files more.
inline constexpr long long expression_bytes = 256LL << 20, file_bytes = 512LL << 20;

class AllocationMeter {
  public:
    explicit AllocationMeter(long long bound = expression_bytes);
    ~AllocationMeter();
    AllocationMeter(const AllocationMeter&) = delete;
    AllocationMeter& operator=(const AllocationMeter&) = delete;
};

/// The fuzzer's bytes under a path, for readers that want one.
class MemoryFile {
  public:
    MemoryFile(const std::uint8_t* data, std::size_t size);
    ~MemoryFile();
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

/// Ends the run with a message, and so keeps the input, unless `holds`.
inline void require(bool holds, std::string_view what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(what.size()), what.data());
    std::abort();
}

}  // namespace fuzz
