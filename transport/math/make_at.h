// Results of functions, where they are to stay.
#pragma once

#include <new>
#include <type_traits>

namespace raylex::transport {

/// place = make(), made there and not copied there. A copy of numbers that have just been written one by one reads them
/// in larger pieces than they were written in, which processors cannot forward from what waits to be stored, so that
/// the copy has to wait. Such copies took 7 % of a render (experiments/docs/measured.md).
template <class T, class Make>
void make_at(T& place, Make make) {
    static_assert(std::is_trivially_destructible_v<T>, "what was there is not destroyed");
    ::new (static_cast<void*>(&place)) T(make());
}

}  // namespace raylex::transport
