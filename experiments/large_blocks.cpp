// The program's operator new. Scenes are read into arrays of hundreds of megabytes. The first access to each 4 kB page
// traps into the kernel, which takes longer than the work on its bytes. This code requests Linux's 2 MB pages instead.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <new>

// Sanitizers have their own operator new. g++ defines a macro for them, clang a feature.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RAYLEX_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAYLEX_SANITIZED
#endif
#endif
#ifndef RAYLEX_SANITIZED

namespace {

/// At least two large pages fit in such a block. Smaller blocks gain nothing and would keep unused memory.
constexpr std::size_t large = std::size_t{4} << 20;

void ask_for_large_pages(void* block, std::size_t size) {
    static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(block) & ~(page - 1);
    // This is only advice; a kernel without such pages ignores it.
    static_cast<void>(::madvise(reinterpret_cast<void*>(begin), size, MADV_HUGEPAGE));
}

/// Calls `get` until it succeeds; throws std::bad_alloc if no new handler is set, as the standard demands.
template <class Get>
void* allocate(std::size_t size, const Get& get) {
    while (true) {
        if (void* block = get()) {
            if (size >= large) ask_for_large_pages(block, size);
            return block;
        }
        const std::new_handler handler = std::get_new_handler();
        if (handler == nullptr) throw std::bad_alloc();
        handler();
    }
}

}  // namespace

void* operator new(std::size_t size) {
    return allocate(size, [size] { return std::malloc(size > 0 ? size : 1); });
}

void* operator new(std::size_t size, std::align_val_t alignment) {
    const auto align = static_cast<std::size_t>(alignment);
    const std::size_t whole = (size + align - 1) & ~(align - 1);
    return allocate(size,
                    [=] { return whole < size ? nullptr : std::aligned_alloc(align, whole > 0 ? whole : align); });
}

void operator delete(void* block) noexcept {
    std::free(block);
}

void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}

void operator delete(void* block, std::align_val_t) noexcept {
    std::free(block);
}

void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
    std::free(block);
}

#endif
