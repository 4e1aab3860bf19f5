#include "transport/materials/closures/closure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

namespace raylex::transport {

static_assert(sizeof(Bsdf) <= 256 && std::is_trivially_copyable_v<Bsdf>, "closures are copied in batches");

namespace {

std::vector<LobeKind>& all_lobes() {
    static std::vector<LobeKind> kinds(lobes::kinds.begin(), lobes::kinds.end());
    return kinds;
}

}  // namespace

std::span<const LobeKind> lobe_kinds() {
    return all_lobes();
}

std::optional<LobeId> add_lobe(const LobeKind& lobe) {
    std::vector<LobeKind>& kinds = all_lobes();
    const auto known = std::find_if(kinds.begin(), kinds.end(), [&](const LobeKind& each) {
        return each.type == lobe.type && each.scatter == lobe.scatter && std::string_view(each.name) == lobe.name;
    });
    if (known != kinds.end()) return static_cast<LobeId>(known - kinds.begin());
    if (kinds.size() > std::numeric_limits<LobeId>::max()) return std::nullopt;
    kinds.push_back(lobe);
    return static_cast<LobeId>(kinds.size() - 1);
}

BsdfEvaluation Bsdf::evaluate_other(const Vec3& wo, const Vec3& wi) const {
    if (!has_density_) return {};
    return dispatch(closure_, [&]<class Closure>(const Closure& closure) {
        if constexpr (WorldClosure<Closure>) return closure.evaluate(frame_, wo, wi);
        else return closure.evaluate(frame_.to_local(wo), frame_.to_local(wi));
    });
}

Real Bsdf::pdf_other(const Vec3& wo, const Vec3& wi) const {
    if (!has_density_) return 0;
    return dispatch(closure_, [&]<class Closure>(const Closure& closure) {
        if constexpr (WorldClosure<Closure>) return closure.pdf(frame_, wo, wi);
        else return closure.pdf(frame_.to_local(wo), frame_.to_local(wi));
    });
}

BsdfSample Bsdf::sample_other(const Vec3& wo_world, Real u_lobe, const Vec2& u) const {
    return dispatch(closure_, [&]<class Closure>(const Closure& closure) {
        if constexpr (WorldClosure<Closure>) {
            return closure.sample(frame_, wo_world, u);
        } else {
            const Vec3 wo = frame_.to_local(wo_world);
            BsdfSample s = closure.sample(wo, u_lobe, u);
            if (!(s.pdf > 0)) return s;
            s.wi = frame_.to_world(s.wi);
            if (s.delta || s.pdf_is_proportional) return s;
            // Turning a direction to world space rounds it. Where the density is steep, on narrow lobes and near the
            // horizon, the density of the rounded direction is another one.
            const Real pdf = closure.pdf(wo, frame_.to_local(s.wi)), change = pdf / s.pdf;
            s.pdf = pdf;
            for (int l = 0; l < s.lobes.count; ++l) s.lobes.entry[static_cast<std::size_t>(l)].value *= change;
            return s;
        }
    });
}

Rgb Bsdf::albedo(const Vec3& wo) const {
    return dispatch(closure_, [&](const auto& closure) { return closure.albedo(frame_.to_local(wo)); });
}

std::optional<SideLobes> Bsdf::side_lobes() const {
    return dispatch(closure_, [](const auto& closure) -> std::optional<SideLobes> {
        if constexpr (requires { closure.side_lobes(); }) return closure.side_lobes();
        else return std::nullopt;
    });
}

const DielectricClosure* Bsdf::interface() const {
    return dispatch(closure_, [](const auto& closure) -> const DielectricClosure* {
        if constexpr (requires { closure.interface; }) return &closure.interface;
        else return nullptr;
    });
}

template <class Edit>
void Bsdf::edit(Edit&& edit_closure) {
    dispatch(closure_, [&](auto& closure) {
        edit_closure(closure);
        has_density_ = closure.has_density();
    });
}

Bsdf Bsdf::without_bias() const {
    Bsdf unbiased = *this;
    unbiased.edit([](auto& closure) {
        if constexpr (requires { closure.coat; }) closure.coat.as_pbrt = false;
    });
    return unbiased;
}

void Bsdf::keep_side(Sides side) {
    edit([&](auto& closure) {
        if constexpr (requires { closure.sides; }) closure.sides = side;
    });
}

void Bsdf::set_index(Real inside) {
    edit([&](auto& closure) {
        if constexpr (requires { closure.interface; }) closure.interface.eta = inside;
    });
}

void Bsdf::regularize() {
    edit([](auto& closure) {
        if constexpr (requires { closure.regularize(); }) closure.regularize();
    });
}

Real Bsdf::inside_ior() const {
    const DielectricClosure* glass = interface();
    return glass != nullptr ? glass->eta : 1.0f;
}

bool Bsdf::reflects_all_alike(const IndexSpectrum& indices, const Vec3& wo) const {
    const DielectricClosure* glass = interface();
    if (glass == nullptr || !glass->facets.smooth()) return false;
    return dot(wo, frame_.n) > 0 ? indices.least() > 1 : indices.most() < 1;
}

Rgb Bsdf::reflected_colours(const Rgb& inside, const Vec3& wo) const {
    const Real cos_o = dot(wo, frame_.n);
    const auto share = [&](Real index) { return fresnel_dielectric(std::abs(cos_o), cos_o > 0 ? index : 1 / index); };
    return Rgb(share(inside.r), share(inside.g), share(inside.b)) / share(interface()->eta);
}

}  // namespace raylex::transport
