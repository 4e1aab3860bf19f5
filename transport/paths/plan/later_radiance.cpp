#include "transport/paths/plan/later_radiance.h"

#include <algorithm>
#include <numeric>

namespace raylex::transport {

void LaterRadiance::begin() {
    vertices_.clear();
    before_.clear();
}

void LaterRadiance::pass(const PassedVertex& vertex) {
    vertices_.push_back(vertex);
    for (std::size_t c = 0; c < channels_.size(); ++c) before_.push_back(received(c, vertex.row));
}

double LaterRadiance::received(std::size_t channel, std::size_t row) const {
    if (!table_.touched(channels_[channel])) return 0;
    const double* values = table_.values(channels_[channel]) + 3 * row;
    return (values[0] + values[1] + values[2]) / 3;
}

/// Rows of a batch are followed side by side: their vertices come in turns.
void LaterRadiance::sort_by_row() {
    std::vector<std::size_t> order(vertices_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return vertices_[a].row < vertices_[b].row; });
    std::vector<PassedVertex> vertices;
    std::vector<double> before;
    for (const std::size_t i : order) {
        vertices.push_back(vertices_[i]);
        const auto values = before_.begin() + static_cast<std::ptrdiff_t>(i * channels_.size());
        before.insert(before.end(), values, values + static_cast<std::ptrdiff_t>(channels_.size()));
    }
    vertices_ = std::move(vertices);
    before_ = std::move(before);
    behind_.resize(before_.size());
}

/// `first`: of its vertices, which are sorted by row.
LaterRadiance::Path LaterRadiance::path_of(std::size_t row, std::size_t first) {
    const std::size_t channels = channels_.size();
    received_.resize(channels);
    for (std::size_t c = 0; c < channels; ++c) received_[c] = received(c, row);
    std::size_t end = first;
    while (end < vertices_.size() && vertices_[end].row == row) ++end;
    for (std::size_t i = first; i < end; ++i) {
        std::size_t next = i + 1;  // where the path went back
        while (next < end && vertices_[next].depth > vertices_[i].depth) ++next;
        const double* until = next < end ? before_.data() + next * channels : received_.data();
        for (std::size_t c = 0; c < channels; ++c) behind_[i * channels + c] = until[c] - before_[i * channels + c];
    }
    return {{vertices_.data() + first, end - first},
            channels,
            before_.data() + first * channels,
            behind_.data() + first * channels,
            received_.data()};
}

}  // namespace raylex::transport
