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
    if (beside_class_) collapse_each_class(target, random);
    if (count > target) collapse(0, count, target, random);
    compact();
}

/// Sorts the branches by the state of the class, and collapses each run of one state.
void BranchList::collapse_each_class(std::size_t target, double random) {
    std::array<std::size_t, room + 1> begin{0};
    std::size_t classes = 0;
    for (std::size_t end = 0; end < count; begin[++classes] = end) {
        const lpe::State of_class = class_of(end);
        for (std::size_t i = end; i < count; ++i) {
            if (class_of(i) != of_class) continue;
            std::swap_ranges(&state[i * words_], &state[i * words_] + words_, &state[end * words_]);
            std::swap(share[i], share[end++]);
        }
    }
    const std::size_t each = std::max(std::size_t{3}, target / classes);
    for (std::size_t k = 0; k < classes; ++k)
        if (begin[k + 1] - begin[k] > each) collapse(begin[k], begin[k + 1], each, random);
    compact();
}

void BranchList::collapse(std::size_t first, std::size_t last, std::size_t target, double random) {
    const std::size_t chosen_count = last - first - target + 3;
    std::array<std::uint16_t, room> order;
    const auto begin = order.begin();
    const auto nth = [&](std::size_t n) { return begin + static_cast<std::ptrdiff_t>(n); };
    std::iota(begin, nth(last - first), static_cast<std::uint16_t>(first));
    std::array<double, room> sizes;
    for (std::size_t i = first; i < last; ++i) sizes[i] = size(i);
    std::partial_sort(begin, nth(chosen_count), nth(last - first), [&](std::uint16_t a, std::uint16_t b) {
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
}

void BranchList::fit(const Branches& of_class) {
    if (of_class.share == nullptr || of_class.count == 0) return;  // the shares sum to 1, or there are none
    for (std::size_t k = 0; k < of_class.count; ++k) {
        const RgbD wanted = of_class.share_of(k);
        RgbD total, scale;
        for (std::size_t i = 0; i < count; ++i)
            if (class_of(i) == of_class.state[k]) total += share[i].rgb();
        for (int c = 0; c < 3; ++c) scale[c] = total[c] > 0 ? wanted[c] / total[c] : 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (class_of(i) != of_class.state[k]) continue;
            const RgbD fitted = share[i].rgb() * scale;
            share[i] = {fitted.r, fitted.g, fitted.b};
        }
    }
}

}  // namespace raylex::display
