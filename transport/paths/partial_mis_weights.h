// The power heuristic over all bidirectional strategies of a path, from a few numbers kept at the ends of its subpaths.
//
// A path of n vertices can be made with s of them from the light and t = n - s from the camera. Two neighbouring
// strategies differ in who made one vertex. Their densities are in the ratio r of that vertex's density as made from
// the other end (reverse) to the density as made from its own end (forward), both per area. The weight is
// w = p_i^2 / sum_j p_j^2 (Veach 1997, equation 9.13 with beta = 2). Its inverse is 1 plus one sum for
// each side of the connection (Georgiev 2012, "Implementing Vertex Connection and Merging", equation 37), and the sum
// of one side is, vertex by vertex away from the connection,
//
//     A(k) = r(k)^2 (c(k) + r(k-1)^2 (c(k-1) + r(k-2)^2 (...)))
//
// where c(k) is 1 if the strategy that connects vertices k - 1 and k exists, and 0 beside a specular vertex. All of A
// but the last two ratios is known when a vertex is made. It is carried along as `tail`, so that a connection costs the
// same at any length. Georgiev's recursion (equations 31 to 36) without merging keeps the same numbers divided by
// densities: with the power heuristic his dVCM is c / forward^2, and his dVC is (to_previous / (forward previous))^2
// tail.
//
// Any function of the path alone is a valid density here, as long as all strategies agree on it. A specular vertex has
// density 1 in both directions, which cancels (equations 53 to 55). Roulette and the alpha test are left out.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "transport/math/real.h"

namespace raylex::transport {

/// Kept at the last vertex of a subpath. Densities are per area; per steradian for a light at infinity.
///
/// `tail` is a sum of squares of products as long as the path. These leave the range of double at some hundred vertices
/// and come back. So `tail` carries an exponent of its own, and stays within 2^-256 and 2^256, or is 0, between steps
/// of at most 2^400. A step beyond that needs densities of 1e30 beside densities of 1e-30.
struct PartialMisWeights {
    double forward = 1;      ///< density of this vertex
    double previous = 1;     ///< density of the vertex before
    double cosine = 1;       ///< |cos| at the vertex before, of the direction in which the subpath left it
    double to_previous = 0;  ///< cosine / distance^2: from steradians here to area at the vertex before
    /// c of this vertex: 1, 0, or a ratio of densities squared where a light sample makes the vertex before.
    double connects = 0;
    double tail = 0;                 ///< c of the vertex before, and of all further ones times their ratios
    std::int32_t tail_exponent = 0;  ///< `tail` counts 2^(512 tail_exponent) times

    /// The square of a ratio of densities, which may be infinite.
    static double squared(double ratio) { return bounded(ratio) * bounded(ratio); }
    /// Georgiev 2012, equation 37. `others`: the sums of both sides.
    static Real weight(double others) { return static_cast<Real>(1 / (1 + others)); }

    /// The sum of p_j^2 / p_i^2, where strategy i connects behind this vertex, and j runs over all strategies that
    /// connect nearer to the beginning of this subpath (Georgiev 2012, equations 40, 41, 46). `reverse`: density per
    /// area of this vertex as made from behind the connection. `reverse_to_previous`: density per steradian of the
    /// direction from here to the vertex before, as sampled by a subpath from behind the connection.
    [[nodiscard]] double others(double reverse, double reverse_to_previous) const {
        const double here = ratio(reverse, forward);
        return here * here * connects + times_tail(here * ratio_to_previous(reverse_to_previous));
    }

    /// The sum of p_j^2 / p_i^2, where strategy i is a camera subpath that meets a light at this vertex, and j runs
    /// over all other strategies (Georgiev 2012, equation 43). `sampled`: density of the vertex's light sample over
    /// that of its direction of arrival. `emission`, `emission_to_previous`: densities with which a light subpath
    /// begins here.
    [[nodiscard]] double others_at_light(double sampled, double emission, double emission_to_previous) const {
        return connects * squared(sampled) +
               times_tail(ratio(emission, forward) * ratio_to_previous(emission_to_previous));
    }

    /// Updates the numbers when the subpath is scattered at this vertex (Georgiev 2012, equations 34 to 36; specular:
    /// 53 to 55). `reverse_to_previous`: density per steradian with which a path from the next vertex is scattered to
    /// the vertex before. Both densities of a specular scattering are 1. `new_cosine`: |cos| of the new direction to
    /// the geometric normal.
    void leave(bool specular, double reverse_to_previous, double new_cosine) {
        tail *= squared(ratio_to_previous(reverse_to_previous));
        rescale_tail();
        if (!specular && connects > 0) {
            if (tail_exponent < 0) tail = 0, tail_exponent = 0;  // less than a rounding of `connects`
            if (tail_exponent == 0) tail += connects;            // otherwise less than a rounding of `tail`
        }
        connects = specular ? 0 : 1;
        previous = forward;
        cosine = new_cosine;
    }
    /// Updates the numbers when the subpath reaches its next vertex. `density`: per area. `near`: 1 / distance^2, or 1
    /// from infinity. If the subpath passes through a cutout at that surface, the call for the next surface replaces
    /// this one.
    void arrive(double density, double near) {
        forward = density;
        to_previous = cosine * near;
    }

  private:
    static double bounded(double ratio) { return std::min(ratio, 0x1p200); }
    static double ratio(double reverse, double made) { return bounded(reverse / std::max(made, 1e-300)); }
    [[nodiscard]] double ratio_to_previous(double reverse) const { return ratio(reverse * to_previous, previous); }
    /// ratio^2 x tail. A strategy outweighed by more than 2^1000 has the weight 0 in any arithmetic.
    [[nodiscard]] double times_tail(double ratio) const {
        if (tail_exponent != 0) ratio = std::ldexp(ratio, 256 * tail_exponent);
        return std::min(ratio * ratio * tail, 0x1p1000);
    }
    void rescale_tail() {
        if (tail > 0x1p256) tail *= 0x1p-512, ++tail_exponent;
        else if (!(tail > 0)) tail_exponent = 0;
        else if (tail < 0x1p-256) tail *= 0x1p512, --tail_exponent;
    }
};

}  // namespace raylex::transport
