// A density of directions at every point of a scene: the SD-tree of T. Müller, M. Gross and J. Novák 2017, "Practical
// Path Guiding for Efficient Light-Transport Simulation".
//
// Space is halved again and again, along x, y and z in turn. Each resulting region has a quadtree over the unit square,
// to which the sphere of directions is mapped (direction_square.h). Within a cell of the quadtree, the density is
// constant over the square. Surfaces that face the six directions of the axes, and points in media, have regions of
// their own: one direction is good for a floor and useless for the wall beside it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/embree/embree_scene.h"

namespace raylex::transport {

class GuideSums;

class GuideTree {
  public:
    /// A node of a quadtree. Its quadrants are numbered row by row; some are divided further by a node of their own,
    /// and these nodes follow one another. Few bytes: lookups wait for memory.
    struct Node {
        static constexpr std::uint32_t whole = 1u << 15;
        std::array<std::uint16_t, 4> mass{whole / 4, whole / 4, whole / 4, whole / 4};  ///< sum: whole
        std::uint32_t first_and_divided = 0;  ///< 16 x the first child, and a bit for each divided quadrant

        /// The share of a quadrant in the density of the node.
        [[nodiscard]] Real share(std::size_t quadrant) const {
            return static_cast<Real>(mass[quadrant]) * (Real(1) / Real{whole});
        }
        /// The node of a quadrant; 0: the quadrant is a cell.
        [[nodiscard]] std::uint32_t child(std::uint32_t quadrant) const {
            if ((first_and_divided >> quadrant & 1) == 0) return 0;
            constexpr std::uint32_t bits_of = 0x32212110;  // four for each: the bits that are set in 0 to 7
            const std::uint32_t before = first_and_divided & ((1u << quadrant) - 1);
            return (first_and_divided >> 4) + (bits_of >> 4 * before & 0xF);
        }
    };
    struct Region {
        std::uint32_t root = 0;    ///< node of its quadtree
        Real share = 0;            ///< probability of drawing a direction from the quadtree; 0: the closure draws all
        std::uint32_t before = 0;  ///< region of the tree before, of which this one is a part
        float by_square = 0, by_noise = 0, by_light = 0;  ///< see guide_gains.h; by_square is 0: unknown
    };
    /// Where a point is.
    struct Place {
        std::uint32_t region = 0;
        std::uint32_t halvings = 0;  ///< of space, down to the region
    };

    static constexpr std::uint32_t orientations = 7;  ///< six sides of surfaces, then points in media
    static constexpr std::uint32_t most_halvings = 48, deepest_node = 12;

    /// One region for each orientation, with a density that is uniform over the square. `box`: the bounds of all
    /// points, of finite size.
    explicit GuideTree(const Bounds& box);

    /// The region of a point. `normal`: the shading normal, zero in a medium. Points outside the box are in the region
    /// at its border.
    [[nodiscard]] Place place_of(const Vec3& position, const Vec3& normal) const;
    [[nodiscard]] const Region& region(std::uint32_t number) const { return regions_[number]; }
    /// The widths of a place's region, in the unit of length of the scene.
    [[nodiscard]] Vec3 extent(const Place& place) const;

    /// Draws a direction from the quadtree of a region; u in [0, 1).
    [[nodiscard]] Vec3 sample(const Region& region, const Vec2& u) const;
    /// The density of sample() per steradian, for a unit direction as it is rounded.
    [[nodiscard]] Real density(const Region& region, const Vec3& direction) const;

    /// Appends the tree to a record, in the byte order of this machine.
    void append_record(std::string& bytes) const;
    /// Returns the tree of a record, or nothing if the bytes are not a tree.
    static std::optional<GuideTree> from_record(std::string_view bytes);

    [[nodiscard]] const std::vector<Region>& regions() const { return regions_; }
    /// Sets Region::by_square, by_noise and by_light.
    void set_gain(std::size_t region, float by_square, float by_noise, float by_light) {
        regions_[region].by_square = by_square;
        regions_[region].by_noise = by_noise;
        regions_[region].by_light = by_light;
    }
    /// Whether the regions have gains.
    [[nodiscard]] bool plans_rays() const { return regions_.front().by_square > 0; }
    [[nodiscard]] std::size_t node_count() const { return nodes_.size(); }
    [[nodiscard]] std::size_t bytes() const {
        return nodes_.size() * sizeof(Node) + regions_.size() * sizeof(Region) + space_.size() * sizeof(Space);
    }
    /// The shares of a region's density in the 2^depth x 2^depth equal cells of the square (direction_square.h), row by
    /// row. Their sum is 1. depth: at most deepest_node.
    [[nodiscard]] std::vector<Real> shares_of_cells(const Region& region, std::uint32_t depth) const;
    /// [region] the side that its surfaces face, as numbered by `orientations`: +x, -x, +y, -y, +z, -z, media.
    [[nodiscard]] std::vector<std::uint8_t> sides() const;
    /// Returns the node and the quadrant of the cell that contains a direction, as 4 node + quadrant.
    [[nodiscard]] std::size_t cell_of(const Region& region, const Vec3& direction) const;

  private:
    friend class GuideRefinement;
    /// A node of the binary trees over space. Its halves are at `first` and `first` + 1.
    struct Space {
        std::uint32_t first = 0, region = 0;  // first: 0 for a leaf
    };

    [[nodiscard]] bool is_sound() const;

    Vec3 lower_, scale_, size_;
    std::vector<Space> space_;  // the first ones are the roots, one for each orientation
    std::vector<Region> regions_;
    std::vector<Node> nodes_;  // every node stands before its children; node 0 is unused
};

}  // namespace raylex::transport
