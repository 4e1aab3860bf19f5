// Measured reflectance in the adaptive parameterisation of Dupuy and Jakob 2018, "An Adaptive Parameterization for
// Efficient Material Acquisition and Rendering": what RGL's .bsdf files hold.
//
// Half vectors are warped to the unit square by the density of visible normals that was measured with the material;
// on that square, where everything is smooth, stand its reflectance and its luminance, for a grid of directions wo:
//
//     f |cos| = reflectance(u; wo) D(m) / (4 sigma(wo)),   u = warp^-1(m; wo)
//
// Angles stand on the square as theta = u^2 pi/2 and phi = (2 v - 1) pi. Sampling draws u by the luminance.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/vec.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The four measured directions around wo, and their weights.
struct MeasuredDirection {
    std::array<std::size_t, 4> slice;
    std::array<Real, 4> weight;
};

/// A density on the unit square for every measured direction, bilinear between the nodes of a grid and linear between
/// directions, with its sampling and the inverse.
class MeasuredWarp {
  public:
    MeasuredWarp() = default;
    /// `values`: [slice][row][column], not negative; every slice is normalised, one of zeros becomes even.
    MeasuredWarp(std::vector<float> values, std::size_t slices, std::size_t rows, std::size_t columns);

    struct Point {
        Vec2 at;
        Real density = 0;  ///< of `at`, or for invert() of its argument
    };
    [[nodiscard]] Point sample(Vec2 u, const MeasuredDirection& direction) const;
    /// The u from which sample() makes `at`, and the density of `at`.
    [[nodiscard]] Point invert(const Vec2& at, const MeasuredDirection& direction) const;
    [[nodiscard]] Real density(const Vec2& at, const MeasuredDirection& direction) const;

  private:
    struct Cell;
    [[nodiscard]] Real mixed(const std::vector<float>& values, std::size_t per_slice, std::size_t index,
                             const MeasuredDirection& direction) const;
    [[nodiscard]] Real row_sum(std::size_t row, const MeasuredDirection& direction) const;
    [[nodiscard]] Cell cell(const Vec2& at) const;

    std::size_t rows_ = 0, columns_ = 0;
    std::vector<float> values_, conditional_, marginal_;
};

class MeasuredReflectance {
  public:
    /// Reads the file and converts its spectra to the rendering space like albedos, except that values above 1 remain.
    static Result<std::shared_ptr<const MeasuredReflectance>> read(const std::string& path, const ColorContext& color);

    [[nodiscard]] Rgb value(Vec3 wo, Vec3 wi) const;
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi) const;
    [[nodiscard]] LocalSample draw(const Vec3& wo, const Vec2& u) const;
    /// Depends on theta alone; for an anisotropic material it is the mean over phi.
    [[nodiscard]] Rgb albedo(Real cosine) const;

    std::string warning;  ///< names values that were set to 0; empty: there are none

  private:
    struct Halfway;
    [[nodiscard]] MeasuredDirection direction_of(const Vec3& wo) const;
    [[nodiscard]] Rgb reflectance(const Vec2& u, const MeasuredDirection& direction) const;
    [[nodiscard]] Real shape(const Vec3& wo, const Vec2& half_vector) const;
    void tabulate_albedo();

    bool isotropic_ = true;
    std::vector<float> theta_, phi_;  // of the measured directions
    MeasuredWarp visible_normals_, luminance_;
    struct Grid {
        std::size_t rows = 0, columns = 0;
        std::vector<float> values;
        [[nodiscard]] Real at(const Vec2& where) const;
    };
    Grid normals_, sigma_;
    std::size_t rows_ = 0, columns_ = 0;
    std::vector<Rgb> spectra_;  // [slice][row][column]
    std::vector<Rgb> albedo_;   // by cosine, even steps from 0 to 1
};

/// Reflects alike on both sides.
struct MeasuredClosure {
    const MeasuredReflectance* table;  ///< the material's

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        return one_lobe(lobes::measured, table->value(wo, wi), pdf(wo, wi));
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real, const Vec2& u) const {
        return one_lobe(lobes::measured, table->draw(wo, u));
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return table->pdf(wo, wi); }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const { return table->albedo(wo.z); }
    [[nodiscard]] static constexpr bool has_density() { return true; }
};

}  // namespace raylex::transport
