// Closures that are not in the tree: a plugin's own lobes, without a cost to the in-tree closures.
//
// A closure is a small trivially copyable struct with the functions of ScatteringClosure. A Bsdf keeps its bytes and a
// pointer to its functions, so calls to it are indirect; calls to in-tree closures are direct. Directions are unit
// vectors in the shading frame, away from the surface, z along the normal; either may lie below the surface.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "transport/materials/bsdf/bsdf.h"

namespace raylex::transport {

/// evaluate     f |cos| of each lobe and their sum, and the density of sample(); nothing from delta lobes
/// sample       a direction wi in the frame, or pdf 0; weight, pdf and lobes as in BsdfSample. u_lobe, u in [0, 1)
/// pdf          the density that evaluate() returns
/// albedo       a rough directional albedo at this cosine, for the albedo AOV
/// has_density  false when every lobe is a delta: then no light is sampled at the surface
///
/// A closure has at most 72 bytes. Larger data belongs to the material, which outlives its closures; the closure keeps
/// a pointer to it.
///
/// Lobes are ids of lobes.h or of PluginHost::add_lobe. Their values must sum to `value` (Law 5).
template <class Closure>
concept ScatteringClosure = std::is_trivially_copyable_v<Closure> &&
    requires(const Closure& c, const Vec3& v, Real number, const Vec2& u) {
    { c.evaluate(v, v) } -> std::same_as<BsdfEvaluation>;
    { c.sample(v, number, u) } -> std::same_as<BsdfSample>;
    { c.pdf(v, v) } -> std::same_as<Real>;
    { c.albedo(number) } -> std::same_as<Rgb>;
    { c.has_density() } -> std::same_as<bool>;
};

/// A plugin closure inside a Bsdf: its bytes, and functions for its type.
class CustomClosure {
  public:
    static constexpr std::size_t room = 72;  ///< with `calls_` as much as the largest in-tree closure takes

    template <ScatteringClosure Closure>
    explicit CustomClosure(const Closure& closure) : calls_(&calls_of<Closure>) {
        static_assert(sizeof(Closure) <= room && alignof(Closure) <= 8,
                      "a closure has 72 bytes, aligned to 8: keep a pointer to what is larger, in the material");
        std::construct_at(reinterpret_cast<Closure*>(data_.data()), closure);
    }

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        return calls_->evaluate(data_.data(), wo, wi);
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        return calls_->sample(data_.data(), wo, u_lobe, u);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return calls_->pdf(data_.data(), wo, wi); }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const { return calls_->albedo(data_.data(), std::abs(wo.z)); }
    [[nodiscard]] bool has_density() const { return calls_->has_density(data_.data()); }

  private:
    struct Calls {
        BsdfEvaluation (*evaluate)(const void*, const Vec3&, const Vec3&);
        BsdfSample (*sample)(const void*, const Vec3&, Real, const Vec2&);
        Real (*pdf)(const void*, const Vec3&, const Vec3&);
        Rgb (*albedo)(const void*, Real);
        bool (*has_density)(const void*);
    };
    template <class Closure>
    static const Closure& as(const void* data) {
        return *static_cast<const Closure*>(data);
    }
    template <class Closure>
    static constexpr Calls calls_of{
        [](const void* data, const Vec3& wo, const Vec3& wi) { return as<Closure>(data).evaluate(wo, wi); },
        [](const void* data, const Vec3& wo, Real u_lobe, const Vec2& u) {
            return as<Closure>(data).sample(wo, u_lobe, u);
        },
        [](const void* data, const Vec3& wo, const Vec3& wi) { return as<Closure>(data).pdf(wo, wi); },
        [](const void* data, Real cos_o) { return as<Closure>(data).albedo(cos_o); },
        [](const void* data) { return as<Closure>(data).has_density(); }};

    const Calls* calls_;
    alignas(8) std::array<std::byte, room> data_;
};

}  // namespace raylex::transport
