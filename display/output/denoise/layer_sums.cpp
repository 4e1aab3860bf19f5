#include "display/output/denoise/layer_sums.h"

#include <algorithm>
#include <cmath>

namespace raylex::display {

LayerSums::LayerSums(std::span<const LayerIdentity> sums, std::size_t layers)
    : sums_(sums), matrix_(sums.size() * sums.size()), multipliers_(sums.size()), free_(layers) {
    for (const LayerIdentity& sum : sums) {
        std::vector<double>& signs = signs_.emplace_back(layers);
        for (const std::size_t layer : sum.layers) signs[layer] += 1;
        signs[sum.of] -= 1;
    }
}

double LayerSums::residual(std::size_t sum, std::span<const double> values) const {
    double total = 0;
    for (std::size_t i = 0; i < values.size(); ++i) total += signs_[sum][i] * values[i];
    return total;
}

/// Cholesky's factor of C E C' with the signs C and the risks E. A sum without risk has no multiplier.
void LayerSums::factor(std::span<const double> risk) {
    const std::size_t n = signs_.size();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (std::size_t k = 0; k < risk.size(); ++k) sum += signs_[i][k] * risk[k] * signs_[j][k];
            const double all = sum;
            for (std::size_t k = 0; k < j; ++k) sum -= matrix_[i * n + k] * matrix_[j * n + k];
            const double pivot = matrix_[j * n + j];
            if (i == j) matrix_[i * n + i] = sum > 1e-12 * all ? std::sqrt(sum) : 0;
            else matrix_[i * n + j] = pivot > 0 ? sum / pivot : 0;
        }
}

void LayerSums::solve(std::span<double> rhs) const {
    const std::size_t n = signs_.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) rhs[i] -= matrix_[i * n + k] * rhs[k];
        rhs[i] = matrix_[i * n + i] > 0 ? rhs[i] / matrix_[i * n + i] : 0;
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) rhs[i] -= matrix_[k * n + i] * rhs[k];
        rhs[i] = matrix_[i * n + i] > 0 ? rhs[i] / matrix_[i * n + i] : 0;
    }
}

void LayerSums::project(std::span<const double> risk, std::span<double> values) {
    factor(risk);
    for (std::size_t i = 0; i < signs_.size(); ++i) multipliers_[i] = residual(i, values);
    solve(multipliers_);
    for (std::size_t k = 0; k < values.size(); ++k)
        for (std::size_t i = 0; i < signs_.size(); ++i) values[k] -= risk[k] * signs_[i][k] * multipliers_[i];
}

void LayerSums::make_sum(std::span<const double> noisy, std::span<const double> risk, std::span<double> denoised) {
    constexpr int most_rounds = 4;
    std::copy(risk.begin(), risk.end(), free_.begin());
    bool is_negative = !signs_.empty();
    for (int round = 0; round < most_rounds && is_negative; ++round) {
        project(free_, denoised);
        is_negative = false;
        for (std::size_t k = 0; k < noisy.size(); ++k)
            if (denoised[k] < 0 && noisy[k] >= 0) {
                denoised[k] = free_[k] = 0;
                is_negative = true;
            }
    }
    if (is_negative) project(free_, denoised);
    bool holds = true;
    for (std::size_t i = 0; i < signs_.size(); ++i) {
        double scale = 0;
        for (std::size_t k = 0; k < noisy.size(); ++k)
            scale += std::abs(signs_[i][k]) * (std::abs(noisy[k]) + std::abs(denoised[k]));
        holds = holds && std::abs(residual(i, denoised)) <= 0x1p-30 * scale;
    }
    // The noisy pixel sums. A shorter step from it to values that sum also sums.
    double step = holds ? 1 : 0;
    for (std::size_t k = 0; k < noisy.size(); ++k)
        if (noisy[k] >= 0 && denoised[k] < 0) step = std::min(step, noisy[k] / (noisy[k] - denoised[k]));
    if (step == 0) std::copy(noisy.begin(), noisy.end(), denoised.begin());
    else if (step < 1)
        for (std::size_t k = 0; k < noisy.size(); ++k) denoised[k] = noisy[k] + step * (denoised[k] - noisy[k]);
}

void LayerSums::reduce_risk(std::span<const double> risk, std::span<double> reduced) {
    factor(risk);
    for (std::size_t k = 0; k < risk.size(); ++k) {
        for (std::size_t i = 0; i < signs_.size(); ++i) multipliers_[i] = signs_[i][k] * risk[k];
        solve(multipliers_);
        reduced[k] = risk[k];
        for (std::size_t i = 0; i < signs_.size(); ++i) reduced[k] -= risk[k] * signs_[i][k] * multipliers_[i];
        reduced[k] = std::max(0.0, reduced[k]);
    }
}

}  // namespace raylex::display
