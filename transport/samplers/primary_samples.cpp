#include "transport/samplers/primary_samples.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "display/services/split_mix.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

constexpr std::uint64_t choices = std::uint64_t{1} << 40;  // beyond the names of all dimensions
constexpr std::uint32_t kind_of_dimension = 1u << 23;      // each kind begins at a multiple: subpath.h

/// A standard normal number from 64 random bits (Box and Muller).
Real normal_number(std::uint64_t bits) {
    const Real u = (static_cast<Real>(bits >> 40) + 0.5f) * 0x1p-24f, v = static_cast<Real>(bits & 0xffffff) * 0x1p-24f;
    return std::sqrt(-2 * elementary::log(u)) * elementary::cos(2 * pi * v);
}

/// Wraps x into [0, 1), whose ends are joined.
Real wrap(Real x) {
    x -= std::floor(x);
    return std::min(x, one_minus_epsilon);
}

}  // namespace

void PrimarySamples::restart(std::uint64_t stream) {
    draws_ = large_draws_ = {stream, 0};
    step_ = last_large_ = 0;
    large_ = true;
    numbers_.clear();
    std::fill(slots_.begin(), slots_.end(), 0u);
}

void PrimarySamples::propose(bool large, Real sigma) {
    ++draws_.mutation;
    ++step_;
    large_ = large;
    sigma_ = sigma;
}

void PrimarySamples::accept() {
    if (!large_) return;
    last_large_ = step_;
    large_draws_ = draws_;
}

void PrimarySamples::reject() {
    for (Number& number : numbers_) {
        if (number.changed != step_) continue;
        number.value = number.kept;
        number.changed = number.kept_changed;
    }
    --step_;
}

std::uint64_t PrimarySamples::Draws::bits(std::uint64_t name) const {
    return mix_bits(mix_bits(stream + mutation * golden_gamma) ^ (name * 0xd1342543de82ef95ull));
}

Real PrimarySamples::choose(std::uint32_t use) const {
    return unit_float(draws_.bits(2 * choices + use));
}

void PrimarySamples::grow() {
    slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), 0u);
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
        std::size_t at = mix_bits(numbers_[i].name) & (slots_.size() - 1);
        while (slots_[at] != 0) at = (at + 1) & (slots_.size() - 1);
        slots_[at] = static_cast<std::uint32_t>(i + 1);
    }
}

PrimarySamples::Number& PrimarySamples::find(std::uint64_t name) {
    if (2 * (numbers_.size() + 1) > slots_.size()) grow();
    std::size_t at = mix_bits(name) & (slots_.size() - 1);
    for (; slots_[at] != 0; at = (at + 1) & (slots_.size() - 1))
        if (Number& number = numbers_[slots_[at] - 1]; number.name == name) return number;
    slots_[at] = static_cast<std::uint32_t>(numbers_.size() + 1);
    Number& fresh = numbers_.emplace_back();
    fresh.name = name;
    return fresh;
}

Real PrimarySamples::get(std::uint32_t dimension, bool second) {
    const std::uint64_t name = 2 * std::uint64_t{dimension} + (second ? 2 : 1);
    if (dimension % kind_of_dimension >= remembered_dimensions)
        return unit_float((large_ ? draws_ : large_draws_).bits(name));
    Number& number = find(name);
    if (number.changed == step_) return number.value;
    if (number.changed <= last_large_ && number.changed != last_large_) {
        // The number did not exist at the last large step, or is older: draw it as that step would have. The draw is
        // keyed to the current mutation, which is as good: no caller has read another value.
        number.value = unit_float(draws_.bits(name + choices));
        number.changed = last_large_;
    }
    number.kept = number.value;
    number.kept_changed = number.changed;
    if (large_) {
        number.value = unit_float(draws_.bits(name));
    } else {
        const auto missed = static_cast<Real>(step_ - number.changed);
        number.value = wrap(number.value + normal_number(draws_.bits(name)) * sigma_ * std::sqrt(missed));
    }
    number.changed = step_;
    return number.value;
}

}  // namespace raylex::transport
