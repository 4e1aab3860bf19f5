// Constructs results of functions in place.
#pragma once

#include <new>
#include <type_traits>

namespace raylex::transport {

/// place = make(), constructed in place without a copy. A copy reads numbers that have just been written one by one in
/// larger pieces; processors cannot forward those from the store buffer, so the copy has to wait. Such copies took 7 %
/// of a render (experiments/docs/measured.md).
template <class T, class Make>
void make_at(T& place, Make make) {
    static_assert(std::is_trivially_destructible_v<T>, "the previous object is not destroyed");
    ::new (static_cast<void*>(&place)) T(make());
}

}  // namespace raylex::transport
