#include "display/buffer/ray_rows.h"

#include <algorithm>
#include <numeric>

namespace raylex::display {

/// Camera rows are first in the table, so each ray's list begins with its camera row.
void RayRows::sort_rows(const SampleTable& table) {
    std::fill(first_.begin(), first_.end(), 0u);
    for (int row = 0; row < table.row_count(); ++row) ++first_[static_cast<std::size_t>(table.original(row)) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (int row = 0; row < table.row_count(); ++row)
        rows_[next[static_cast<std::size_t>(table.original(row))]++] = row;
    const auto nearer = [&](int a, int b) {
        return table.depth[static_cast<std::size_t>(a)] < table.depth[static_cast<std::size_t>(b)];
    };
    for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
        const auto begin = rows_.begin() + first_[i], end = rows_.begin() + first_[i + 1];
        if (end - begin > 1 && !std::is_sorted(begin, end, nearer)) std::stable_sort(begin, end, nearer);
    }
}

void RayRows::gather(const SampleTable& table) {
    const auto cameras = static_cast<std::size_t>(table.camera_row_count());
    const auto rows = static_cast<std::size_t>(table.row_count());
    any_extra_ = rows > cameras;
    any_partial_ = false;
    rows_.resize(rows);
    coverage_.resize(rows);
    first_.resize(cameras + 1);
    alpha_.resize(cameras);
    if (!any_extra_) return gather_single_rows(table);
    ordered_ = 0;
    sort_rows(table);
    for (std::size_t ray = 0; ray < cameras; ++ray) {
        RgbD transmittance{1.0};
        double before = 1;
        for (std::uint32_t i = first_[ray]; i < first_[ray + 1]; ++i) {
            transmittance *= RgbD(1.0) - table.opacity[static_cast<std::size_t>(rows_[i])];
            const double behind = transmittance.average();
            coverage_[i] = before - behind;
            before = behind;
        }
        alpha_[ray] = 1.0 - before;
        any_partial_ |= alpha_[ray] != 0 && alpha_[ray] != 1;
    }
}

/// The usual batch: each ray has only its camera row.
void RayRows::gather_single_rows(const SampleTable& table) {
    const std::size_t cameras = alpha_.size();
    if (ordered_ < cameras) {
        std::iota(rows_.begin(), rows_.end(), 0);
        std::iota(first_.begin(), first_.end(), 0u);
    }
    ordered_ = cameras;
    for (std::size_t ray = 0; ray < cameras; ++ray) {
        const double alpha = 1.0 - (RgbD(1.0) - table.opacity[ray]).average();
        alpha_[ray] = coverage_[ray] = alpha;
        any_partial_ |= alpha != 0 && alpha != 1;
    }
}

WrittenMean written_mean(const SampleTable& table, ChannelId id, std::span<const int> rows,
                         std::span<const double> coverage) {
    const auto components = static_cast<std::size_t>(component_count(table.channel(id).type));
    const auto value_of = [&](int row) { return table.values(id) + static_cast<std::size_t>(row) * components; };
    WrittenMean mean;
    std::array<double, 3> sum{};
    double covered = 0;
    int written = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const SampleTable::RowState state = table.row_state(id, rows[i]);
        mean.set |= state != SampleTable::RowState::untouched;
        if (state != SampleTable::RowState::written) continue;
        if (mean.first < 0) mean.first = rows[i];
        ++written;
        covered += coverage[i];
        for (std::size_t c = 0; c < components && coverage[i] != 0; ++c) sum[c] += coverage[i] * value_of(rows[i])[c];
    }
    mean.any = written > 0;
    mean.covers = covered > 0;
    if (!mean.any) return mean;
    const bool weighted = mean.covers && written > 1;  // a single value is its own mean, bit for bit
    for (std::size_t c = 0; c < components; ++c) mean.value[c] = weighted ? sum[c] / covered : value_of(mean.first)[c];
    return mean;
}

}  // namespace raylex::display
