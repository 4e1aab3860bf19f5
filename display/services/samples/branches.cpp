#include "display/services/samples/branches.h"

#include <algorithm>
#include <numeric>

namespace raylex::display {

void Fractions::pick(double random) {
    for (int c = 0; c < 3; ++c) {
        if (!proportional_[c]) continue;
        double below = 0;
        for (std::size_t j = 0; j < parts_.size(); ++j) {
            const double value = static_cast<double>(parts_[j].value[c]);
            if (value <= 0) continue;
            picked_[c] = j;  // the last part with a value, in case rounding leaves the sum below the target
            below += value;
            if (random * total_[c] < below) break;
        }
        proportional_[c] = false;
    }
}

void BranchList::compact() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (size(i) == 0) continue;
        std::copy_n(&state[i * words_], words_, &state[kept * words_]);
        share[kept++] = share[i];
    }
    count = kept;
}

void BranchList::collapse(std::size_t target, double random) {
    const std::size_t chosen_count = count - target + 3;
    std::array<std::uint16_t, room> order;
    const auto begin = order.begin();
    const auto nth = [&](std::size_t n) { return begin + static_cast<std::ptrdiff_t>(n); };
    std::iota(begin, nth(count), std::uint16_t{0});
    std::array<double, room> sizes;
    for (std::size_t i = 0; i < count; ++i) sizes[i] = size(i);
    std::partial_sort(begin, nth(chosen_count), nth(count), [&](std::uint16_t a, std::uint16_t b) {
        return sizes[a] != sizes[b] ? sizes[a] < sizes[b] : a < b;
    });
    for (double BranchShare::*const color : {&BranchShare::r, &BranchShare::g, &BranchShare::b}) {
        double total = 0, below = 0;
        for (std::size_t k = 0; k < chosen_count; ++k) total += share[order[k]].*color;
        std::size_t survivor = order[0];
        bool found = false;
        for (std::size_t k = 0; k < chosen_count; ++k) {
            double& of_branch = share[order[k]].*color;
            if (!found && of_branch > 0) survivor = order[k];
            below += of_branch;
            found = found || random * total < below;
            of_branch = 0;
        }
        share[survivor].*color = total;
    }
    compact();
}

}  // namespace raylex::display
