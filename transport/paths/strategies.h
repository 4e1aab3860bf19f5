// The power heuristic over all bidirectional strategies of a path, from a few numbers kept at the ends of its subpaths.
//
// A path of n vertices can be made with s of them from the light and t = n - s from the camera. Strategies next to each
// other differ in who made one vertex, so their densities are in the ratio of that vertex's density as made from the
// other end (reverse) and from its own (forward), both per area. With the weight w = p_i^2 / sum_j p_j^2 (Veach 1997,
// section 9.2.2), the sum over one side of a join is, vertex by vertex away from it,
//
//     A(k) = r(k)^2 (join(k) + r(k-1)^2 (join(k-1) + r(k-2)^2 (...))),     r = reverse / forward
//
// where join(k) says whether the strategy that joins vertices k - 1 and k exists: not beside a specular vertex. All of
// it but the last two ratios is known when a vertex is made and is carried along as `tail` (as in Georgiev 2012,
// "Implementing Vertex Connection and Merging", for the balance heuristic), so that a join costs the same at any
// length. Any function of the path alone is a valid density here, as long as all strategies agree on it; a specular
// vertex has density 1 in both directions, which cancels, and roulette and the alpha test are left out.
#pragma once

#include <algorithm>

namespace raylex::transport {

/// Kept at the last vertex of a subpath. Densities are per area; per steradian for a light at infinity. `tail` is a sum
/// of squares of products as long as the path, which leave the range of double at some hundred vertices and come back:
/// it wants an exponent of 15 bits.
struct StrategySums {
    using Wide = long double;
    /// A strategy that is outweighed by so much has the weight 0 in any arithmetic; what is larger would not stay a
    /// number when it is multiplied by a zero further on.
    static constexpr Wide most = 1e1000L;

    double forward = 1;      ///< of this vertex
    double previous = 1;     ///< of the one before
    double to_previous = 0;  ///< |cos| at the one before / distance^2: from steradians here to area there
    Wide join = 0;  ///< of this vertex and the one before: 1, 0 when that is specular, or a ratio of densities squared
    Wide tail = 0;  ///< join of the two before, and of all further ones times their ratios

    /// Of a ratio of densities, which may be infinite.
    static Wide squared(Wide ratio) {
        const Wide r = std::min(ratio, Wide(1e500L));
        return r * r;
    }
    /// The weight of a strategy beside `others`.
    static Real weight(Wide others) { return static_cast<Real>(1 / (1 + others)); }

    /// What all strategies that join nearer to this subpath's beginning weigh, as a share of the one that joins behind
    /// this vertex. `reverse`: density per area of this vertex as made from behind the join; `reverse_to_previous`: of
    /// the direction from here to the vertex before, per steradian, as sampled by a subpath from behind the join.
    [[nodiscard]] Wide others(double reverse, double reverse_to_previous) const {
        return std::min(ratio_squared(reverse, forward) * (join + to_previous_squared(reverse_to_previous) * tail),
                        most);
    }

    /// The same for a camera subpath that has found a light by itself, at this vertex: `sampled` is the density of its
    /// light sample over that of the direction it came in, `emission` that with which a light subpath begins here.
    [[nodiscard]] Wide others_at_light(double sampled, double emission, double emission_to_previous) const {
        return std::min(join * squared(sampled) +
                            ratio_squared(emission, forward) * to_previous_squared(emission_to_previous) * tail,
                        most);
    }

    /// The subpath has been scattered here: `reverse_to_previous` as above, of a scattering that came from the next
    /// vertex. Both densities of a specular one are 1.
    void leave(bool specular, double reverse_to_previous) {
        tail = std::min((specular ? Wide(0) : join) + to_previous_squared(reverse_to_previous) * tail, most);
        join = specular ? 0 : 1;
        previous = forward;
    }
    /// The next vertex has been reached: its density per area, and the factor from steradians there to area here.
    void arrive(double density, double to_area) {
        forward = density;
        to_previous = to_area;
    }

  private:
    static Wide ratio_squared(double reverse, double made) { return squared(reverse / std::max(made, 1e-300)); }
    [[nodiscard]] Wide to_previous_squared(double reverse) const {
        return ratio_squared(reverse * to_previous, previous);
    }
};

}  // namespace raylex::transport
