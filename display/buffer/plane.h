// Arrays of the size of an image.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>

#include <sys/mman.h>

namespace raylex::display {

/// A zeroed array whose untouched pages cost no memory. For every T here, all-zero bits mean "nothing yet".
///
/// Large arrays use large pages: a tile of pixels uses some rows of every channel's plane, each on its own page. With
/// 45 layers on two threads, page faults and address-cache misses caused three quarters of the cost of layers.
template <class T>
class Plane {
  public:
    void allocate(std::size_t count) {
        const std::size_t bytes = count * sizeof(T);
        void* data = bytes >= large_page ? map(bytes) : std::calloc(std::max<std::size_t>(count, 1), sizeof(T));
        if (data == nullptr) throw std::bad_alloc();
        data_ = std::unique_ptr<T, Release>(static_cast<T*>(data), Release{bytes >= large_page ? bytes : 0});
        count_ = count;
    }
    [[nodiscard]] bool empty() const { return count_ == 0; }
    [[nodiscard]] std::size_t size() const { return count_; }
    T& operator[](std::size_t i) { return data_.get()[i]; }
    const T& operator[](std::size_t i) const { return data_.get()[i]; }
    [[nodiscard]] std::span<T> values() { return {data_.get(), count_}; }
    [[nodiscard]] std::span<const T> values() const { return {data_.get(), count_}; }
    [[nodiscard]] std::span<char> bytes() { return {reinterpret_cast<char*>(data_.get()), count_ * sizeof(T)}; }
    [[nodiscard]] std::span<const char> bytes() const {
        return {reinterpret_cast<const char*>(data_.get()), count_ * sizeof(T)};
    }

  private:
    static constexpr std::size_t large_page = std::size_t{2} << 20;
    static void* map(std::size_t bytes) {
        void* data = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (data == MAP_FAILED) return nullptr;
        madvise(data, bytes, MADV_HUGEPAGE);  // a hint: small pages work, too
        return data;
    }
    struct Release {
        std::size_t mapped = 0;  // bytes; 0: from the heap
        void operator()(T* data) const {
            if (mapped > 0) munmap(data, mapped);
            else std::free(data);
        }
    };
    std::unique_ptr<T, Release> data_;
    std::size_t count_ = 0;
};

}  // namespace raylex::display
