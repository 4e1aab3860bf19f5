// The rows of a batch by camera ray, front to back, and what a sample with several rows comes to. Frame buffer, deep
// image and mattes all go by it.
//
// Coverage. The transmittance T is 1 in front of the first row, and behind row i of opacity o_i it is T (1 - o_i),
// colour by colour. Row i covers the mean over the colours of what it takes from T. The coverages of a sample's rows
// sum to its alpha.
//
// Written values. What is written to some rows of a sample means, for the pixel filter,
//     alpha x the mean of the written values, each weighted by the coverage of its row.
// A pixel divided by its alpha is thus the mean of what was written, whether an integrator writes to the first row or
// to all of them. Where no written row covers anything, the mean is the value of the first one; a sample of alpha 0 (a
// ray that met nothing, a holdout) counts its mean whole. In a deep image each row has its own value, and a row without
// one has the mean.
//
// Splatted values of a sample's rows add up: they are shares of one sum, as light is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// Scratch of one thread: it keeps its memory from batch to batch.
class RayRows {
  public:
    void gather(const SampleTable& table);

    /// Whether some ray has more than its camera row.
    [[nodiscard]] bool any_extra() const { return any_extra_; }
    /// Whether some sample's alpha is neither 0 nor 1: then a written value is not simply the pixel filter's.
    [[nodiscard]] bool any_partial() const { return any_partial_; }
    /// The rows of a camera ray, front to back; at equal depth the camera row first, then in the order of add_sample.
    [[nodiscard]] std::span<const int> of(int camera_row) const { return slice(rows_, camera_row); }
    /// What each of these rows covers.
    [[nodiscard]] std::span<const double> coverage(int camera_row) const { return slice(coverage_, camera_row); }
    /// [camera row]
    [[nodiscard]] std::span<const double> alpha() const { return alpha_; }

  private:
    template <class T>
    [[nodiscard]] std::span<const T> slice(const std::vector<T>& list, int camera_row) const {
        const auto i = static_cast<std::size_t>(camera_row);
        return {list.data() + first_[i], list.data() + first_[i + 1]};
    }
    void sort_rows(const SampleTable& table);
    void gather_single_rows(const SampleTable& table);

    std::vector<int> rows_;
    std::vector<double> coverage_;      // beside rows_
    std::vector<std::uint32_t> first_;  // [camera row] into rows_, one more at the end
    std::vector<double> alpha_;
    std::size_t ordered_ = 0;  // rays whose entries in rows_ and first_ are those of single rows
    bool any_extra_ = false, any_partial_ = false;
};

/// What was written to a plain channel in the rows of one sample.
struct WrittenMean {
    bool set = false;               ///< something was written or splatted
    bool any = false;               ///< something was written
    bool covers = false;            ///< some written row covers something
    int first = -1;                 ///< the first written row
    std::array<double, 3> value{};  ///< see above
};
WrittenMean written_mean(const SampleTable& table, ChannelId id, std::span<const int> rows,
                         std::span<const double> coverage);

}  // namespace raylex::display
