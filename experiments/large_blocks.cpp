// The program's operator new. Scenes are read into arrays of hundreds of megabytes, and a first touch of each 4 kB of
// them is a trap into the kernel, which takes longer than what is done with the bytes. Linux has pages of 2 MB for
// those who say so, as this does.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <new>

// Sanitizers have an operator new of their own. g++ defines a macro for them, clang has features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RAYLEX_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAYLEX_SANITIZED
#endif
#endif
#ifndef RAYLEX_SANITIZED

namespace {

/// Two large pages at least fit in: no smaller block gains, and none is to keep memory that it does not use.
constexpr std::size_t large = std::size_t{4} << 20;

void ask_for_large_pages(void* block, std::size_t size) {
    static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(block) & ~(page - 1);
    // Advice alone: a kernel without such pages says no, and nothing is lost.
    static_cast<void>(::madvise(reinterpret_cast<void*>(begin), size, MADV_HUGEPAGE));
}

/// As the standard has it of operator new: until `get` succeeds or nobody can help.
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
