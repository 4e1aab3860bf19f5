// Aborts, so that the fuzzer keeps the input, when one input has more allocated at once than its target allows. Counted
// by the sanitizer's hooks from the start of the input, so that the fuzzer's own corpus does not count.
#include <sanitizer/allocator_interface.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/fuzz.h"

namespace fuzz {
namespace {

std::atomic<long long> bound{0};
std::atomic<long long> in_use{0};
thread_local bool counting = false;

void on_malloc(const volatile void* /*memory*/, std::size_t size) {
    if (!counting) return;
    if ((in_use += static_cast<long long>(size)) > bound) {
        counting = false;
        std::fprintf(stderr, "more than %lld bytes in use\n", bound.load());
        std::abort();
    }
}

void on_free(const volatile void* memory) {
    if (counting && memory != nullptr) {
        in_use -= static_cast<long long>(__sanitizer_get_allocated_size(const_cast<const void*>(memory)));
    }
}

const int installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);

}  // namespace

AllocationMeter::AllocationMeter(long long most) {
    require(installed > 0, "the allocation hooks are installed");
    in_use = 0;
    bound = most;
    counting = true;
}

AllocationMeter::~AllocationMeter() {
    counting = false;
}

}  // namespace fuzz
