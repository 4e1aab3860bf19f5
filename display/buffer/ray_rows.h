// The rows of a batch by camera ray, front to back, and the value of a sample with several rows. Frame buffer, deep
// image and mattes share these definitions.
//
// Coverage. The transmittance T is 1 in front of the first row; behind row i with opacity o_i it is multiplied by 1 -
// o_i, per colour. The coverage of row i is the mean over the colours of its reduction of T. The coverages of a
// sample's rows sum to its alpha.
//
// Written values. If values are written to several rows of a sample, its value for the pixel filter is
//     alpha x the mean of the written values, each weighted by the coverage of its row.
// So a pixel divided by its alpha is the mean of the written values, whether an integrator writes to the first row or
// to all of them. If no written row covers anything, the mean is the value of the first one; a sample of alpha 0 (a ray
// without a hit, a holdout) counts with its full mean. In a deep image each row has its own value, and a row without
// one has the mean.
//
// Splatted values of a sample's rows add up, because they are parts of one sum, like light.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// Scratch memory of one thread; batches reuse it.
class RayRows {
  public:
    void gather(const SampleTable& table);

    /// Returns whether some ray has more than its camera row.
    [[nodiscard]] bool any_extra() const { return any_extra_; }
    /// Returns whether some sample's alpha is neither 0 nor 1, so that a written value is not its filtered value.
    [[nodiscard]] bool any_partial() const { return any_partial_; }
    /// The rows of a camera ray, front to back. At equal depth the camera row comes first, then the order of
    /// add_sample().
    [[nodiscard]] std::span<const int> of(int camera_row) const { return slice(rows_, camera_row); }
    /// The coverage of each row of a camera ray.
    [[nodiscard]] std::span<const double> coverage(int camera_row) const { return slice(coverage_, camera_row); }
    /// The alpha of each sample: [camera row]
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
    std::vector<double> coverage_;      // parallel to rows_
    std::vector<std::uint32_t> first_;  // [camera row] offset into rows_, plus one entry at the end
    std::vector<double> alpha_;
    std::size_t ordered_ = 0;  // number of rays whose entries in rows_ and first_ are those of single rows
    bool any_extra_ = false, any_partial_ = false;
};

/// The written values of a plain channel in the rows of one sample.
struct WrittenMean {
    bool set = false;               ///< a value was written or splatted
    bool any = false;               ///< a value was written
    bool covers = false;            ///< a written row has coverage
    int first = -1;                 ///< the first written row
    std::array<double, 3> value{};  ///< the mean, see above
};
WrittenMean written_mean(const SampleTable& table, ChannelId id, std::span<const int> rows,
                         std::span<const double> coverage);

}  // namespace raylex::display
