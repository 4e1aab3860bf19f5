// What a guide learned, as the pixels of an image see it: for statistics and pages.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "transport/paths/guide/guide_tree.h"

namespace raylex::transport {

struct GuideView {
    static constexpr std::uint32_t no_region = ~std::uint32_t{0};

    GuideTree tree;
    std::uint32_t step = 1, width = 0, height = 0;  ///< point (x, y) of the grid is the pixel (step x, step y)
    /// [y width + x] GuideTree::regions() at the first vertex behind the pixel that is not specular; no_region: there
    /// is none, or a material that is not guided. Of several such vertices under a pixel, a random one.
    std::vector<std::uint32_t> regions{};
    /// World to camera space (x to the right, y up, z into the image), for directions; row by row.
    std::array<Real, 9> to_camera{};

    /// GuideTree::Region::share of a point's region, or 0.
    [[nodiscard]] Real share(std::size_t point) const {
        return regions[point] == no_region ? Real(0) : tree.regions()[regions[point]].share;
    }
    /// The share of the points whose region is guided.
    [[nodiscard]] double guided() const {
        std::size_t guided = 0;
        for (std::size_t i = 0; i < regions.size(); ++i) guided += share(i) > 0 ? 1 : 0;
        return static_cast<double>(guided) / static_cast<double>(regions.size());
    }
};

}  // namespace raylex::transport
