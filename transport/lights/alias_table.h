// Discrete choice in constant time (Walker 1977; Vose's construction, 1991).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "transport/math/sampling.h"

namespace raylex::transport {

class AliasTable {
  public:
    AliasTable() = default;
    /// Weights >= 0. If all are 0 the table is empty, and nothing can be chosen.
    explicit AliasTable(const std::vector<double>& weights) {
        double total = 0;
        for (const double w : weights) total += w;
        if (!(total > 0)) return;
        const std::size_t n = weights.size();
        std::vector<double> scaled(n);
        std::vector<std::uint32_t> small, large;
        bins_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            scaled[i] = weights[i] / total * static_cast<double>(n);
            bins_[i].probability = static_cast<Real>(weights[i] / total);
            (scaled[i] < 1 ? small : large).push_back(static_cast<std::uint32_t>(i));
        }
        while (!small.empty() && !large.empty()) {
            const std::uint32_t s = small.back(), l = large.back();
            small.pop_back();
            bins_[s].threshold = static_cast<Real>(scaled[s]);
            bins_[s].alias = l;
            scaled[l] -= 1 - scaled[s];
            if (scaled[l] < 1) {
                large.pop_back();
                small.push_back(l);
            }
        }
        // Rounding leaves bins that should be full; an item of weight 0 must still never be chosen.
        const std::uint32_t heaviest = heaviest_of(weights);
        for (const std::uint32_t i : large) bins_[i] = {1.0f, i, bins_[i].probability};
        for (const std::uint32_t i : small)
            bins_[i] = {weights[i] > 0 ? 1.0f : 0.0f, weights[i] > 0 ? i : heaviest, bins_[i].probability};
    }

    [[nodiscard]] bool empty() const { return bins_.empty(); }
    /// Chooses an item with u in [0, 1).
    [[nodiscard]] std::uint32_t choose(Real u) const {
        const Real scaled = u * static_cast<Real>(bins_.size());
        std::size_t i = static_cast<std::size_t>(scaled);
        if (i >= bins_.size()) i = bins_.size() - 1;
        return scaled - static_cast<Real>(i) < bins_[i].threshold ? static_cast<std::uint32_t>(i) : bins_[i].alias;
    }
    /// Chooses an item like choose(), and makes `u` uniform in [0, 1) again. `u` loses log2(size) of its 24 bits, so
    /// this is for small tables.
    [[nodiscard]] std::uint32_t choose_and_remap(Real& u) const {
        const Real scaled = u * static_cast<Real>(bins_.size());
        std::size_t i = static_cast<std::size_t>(scaled);
        if (i >= bins_.size()) i = bins_.size() - 1;
        const Real rest = scaled - static_cast<Real>(i), threshold = bins_[i].threshold;
        const bool own = rest < threshold;
        u = std::min(own ? rest / threshold : (rest - threshold) / (1 - threshold), one_minus_epsilon);
        return own ? static_cast<std::uint32_t>(i) : bins_[i].alias;
    }
    [[nodiscard]] std::size_t size() const { return bins_.size(); }
    [[nodiscard]] Real probability(std::uint32_t i) const { return bins_.empty() ? 0.0f : bins_[i].probability; }

  private:
    struct Bin {
        Real threshold = 1;
        std::uint32_t alias = 0;
        Real probability = 0;
    };
    static std::uint32_t heaviest_of(const std::vector<double>& weights) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < weights.size(); ++i)
            if (weights[i] > weights[best]) best = i;
        return static_cast<std::uint32_t>(best);
    }
    std::vector<Bin> bins_;
};

}  // namespace raylex::transport
