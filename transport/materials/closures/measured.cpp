#include "transport/materials/closures/measured.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "display/services/elementary.h"
#include "transport/color/spectrum.h"
#include "transport/files/tensor_file.h"
#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/microfacet.h"

namespace raylex::transport {

namespace {

constexpr int albedo_steps = 16, albedo_side = 24;

Vec2 square_of(Real theta, Real phi) {
    const Real v = phi * (inv_pi / 2) + Real(0.5);
    return {std::sqrt(std::max(theta, Real(0)) * (2 * inv_pi)), v - std::floor(v)};
}

Real theta_of(const Vec3& w) {  // by the chord: an arc cosine is inexact at the pole
    const Real half = std::sqrt(square(w.x) + square(w.y) + square(w.z - 1)) / 2;
    return 2 * elementary::asin(std::clamp(half, Real(0), Real(1)));
}

/// Nodes around `x` and the share of the second.
struct MeasuredNodes {
    std::size_t first, second;
    Real share;
};
MeasuredNodes nodes_around(const std::vector<float>& nodes, Real x) {
    if (nodes.size() < 2) return {0, 0, 0};
    std::size_t i = 0;
    while (i + 2 < nodes.size() && static_cast<Real>(nodes[i + 1]) <= x) ++i;
    const auto a = static_cast<Real>(nodes[i]), b = static_cast<Real>(nodes[i + 1]);
    return {i, i + 1, b > a ? std::clamp((x - a) / (b - a), Real(0), Real(1)) : 0};
}

}  // namespace

/// The half vector of a pair above the surface, on the square.
struct MeasuredReflectance::Halfway {
    Vec2 at;
    Real cosine, jacobian;  // of wo to it; of half vectors per area of the square
    bool valid = false;

    Halfway(const Vec3& wo, const Vec3& m, bool isotropic) {
        cosine = dot(wo, m);
        if (!(cosine > 0)) return;
        const Real theta = theta_of(m), phi_o = isotropic ? elementary::atan2(wo.y, wo.x) : Real(0);
        at = square_of(theta, elementary::atan2(m.y, m.x) - phi_o);
        jacobian = std::max(2 * pi * pi * at.x * elementary::sin(theta), Real(1e-6));
        valid = true;
    }
};

Real MeasuredReflectance::Grid::at(const Vec2& where) const {
    const Real x = std::clamp(where.x, Real(0), Real(1)) * static_cast<Real>(columns - 1),
               y = std::clamp(where.y, Real(0), Real(1)) * static_cast<Real>(rows - 1);
    const auto column = std::min(static_cast<std::size_t>(x), columns - 2),
               row = std::min(static_cast<std::size_t>(y), rows - 2);
    const float* v = values.data() + row * columns + column;
    const Real s = x - static_cast<Real>(column), t = y - static_cast<Real>(row);
    return lerp(t, lerp(s, Real(v[0]), Real(v[1])), lerp(s, Real(v[columns]), Real(v[columns + 1])));
}

MeasuredDirection MeasuredReflectance::direction_of(const Vec3& wo) const {
    const MeasuredNodes theta = nodes_around(theta_, theta_of(wo));
    const MeasuredNodes phi = isotropic_ ? MeasuredNodes{0, 0, 0} : nodes_around(phi_, elementary::atan2(wo.y, wo.x));
    const std::size_t n = theta_.size();
    return {{phi.first * n + theta.first, phi.first * n + theta.second, phi.second * n + theta.first,
             phi.second * n + theta.second},
            {(1 - phi.share) * (1 - theta.share), (1 - phi.share) * theta.share, phi.share * (1 - theta.share),
             phi.share * theta.share}};
}

Rgb MeasuredReflectance::reflectance(const Vec2& u, const MeasuredDirection& direction) const {
    const Real x = std::clamp(u.x, Real(0), Real(1)) * static_cast<Real>(columns_ - 1),
               y = std::clamp(u.y, Real(0), Real(1)) * static_cast<Real>(rows_ - 1);
    const auto column = std::min(static_cast<std::size_t>(x), columns_ - 2),
               row = std::min(static_cast<std::size_t>(y), rows_ - 2);
    const Real s = x - static_cast<Real>(column), t = y - static_cast<Real>(row);
    Rgb sum;
    for (std::size_t k = 0; k < 4; ++k) {
        if (!(direction.weight[k] > 0)) continue;
        const Rgb* v = spectra_.data() + (direction.slice[k] * rows_ + row) * columns_ + column;
        sum += ((v[0] * (1 - s) + v[1] * s) * (1 - t) + (v[columns_] * (1 - s) + v[columns_ + 1] * s) * t) *
               direction.weight[k];
    }
    return sum;
}

/// D(m) / (4 sigma(wo)).
Real MeasuredReflectance::shape(const Vec3& wo, const Vec2& half_vector) const {
    const Real sigma = sigma_.at(square_of(theta_of(wo), isotropic_ ? 0 : elementary::atan2(wo.y, wo.x)));
    return sigma > 0 ? normals_.at(half_vector) / (4 * sigma) : 0;
}

Rgb MeasuredReflectance::value(Vec3 wo, Vec3 wi) const {
    if (!to_upper_side(wo, wi)) return {};
    const Halfway half(wo, normalize(wo + wi), isotropic_);
    if (!half.valid) return {};
    const MeasuredDirection direction = direction_of(wo);
    return reflectance(visible_normals_.invert(half.at, direction).at, direction) * shape(wo, half.at);
}

Real MeasuredReflectance::pdf(Vec3 wo, Vec3 wi) const {
    if (!to_upper_side(wo, wi)) return 0;
    const Halfway half(wo, normalize(wo + wi), isotropic_);
    if (!half.valid) return 0;
    const MeasuredDirection direction = direction_of(wo);
    const MeasuredWarp::Point u = visible_normals_.invert(half.at, direction);
    return luminance_.density(u.at, direction) * u.density / (4 * half.cosine * half.jacobian);
}

LocalSample MeasuredReflectance::draw(const Vec3& wo_given, const Vec2& u) const {
    LocalSample s;
    if (std::abs(wo_given.z) < min_cosine) return s;
    const bool below = wo_given.z < 0;
    const Vec3 wo = below ? -wo_given : wo_given;
    const MeasuredDirection direction = direction_of(wo);
    const Vec2 on_square = luminance_.sample(u, direction).at;
    const Vec2 at = visible_normals_.sample(on_square, direction).at;
    const Real theta = square(at.x) * (pi / 2);
    const Real phi = (2 * at.y - 1) * pi + (isotropic_ ? elementary::atan2(wo.y, wo.x) : 0);
    const auto polar = elementary::sin_cos(theta), around = elementary::sin_cos(phi);
    const Vec3 m{polar.sin * around.cos, polar.sin * around.sin, polar.cos};
    const Vec3 wi = reflect(wo, m);
    if (wi.z < min_cosine || !(dot(wo, m) > 0)) return s;
    s.pdf = pdf(wo, wi);
    if (!(s.pdf > 0)) return s;
    s.weight = value(wo, wi) / s.pdf;
    s.wi = below ? -wi : wi;
    return s;
}

Rgb MeasuredReflectance::albedo(Real cosine) const {
    const Real x = std::clamp(std::abs(cosine), Real(0), Real(1)) * albedo_steps;
    const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(albedo_steps - 1));
    const Real t = x - static_cast<Real>(i);
    return albedo_[i] * (1 - t) + albedo_[i + 1] * t;
}

void MeasuredReflectance::tabulate_albedo() {
    for (int step = 0; step <= albedo_steps; ++step) {
        const Real cosine = std::max(static_cast<Real>(step) / albedo_steps, Real(0.01)),
                   sine = safe_sqrt(1 - cosine * cosine);
        Rgb sum;
        for (int i = 0; i < albedo_side; ++i)
            for (int j = 0; j < albedo_side; ++j) {
                const auto turn = elementary::sin_cos(2 * pi * static_cast<Real>(i * albedo_side + j) /
                                                      Real(albedo_side * albedo_side));
                sum +=
                    draw({sine * turn.cos, sine * turn.sin, cosine}, {(static_cast<Real>(i) + Real(0.5)) / albedo_side,
                                                                      (static_cast<Real>(j) + Real(0.5)) / albedo_side})
                        .weight;
            }
        albedo_.push_back(sum * (1 / Real(albedo_side * albedo_side)));
    }
}

namespace {

/// Reads the fields of a tensor file, and notes what is wrong.
struct FieldReader {
    std::map<std::string, Tensor>& fields;
    std::string wrong, first_bad;
    std::size_t bad = 0;

    /// The field of this name, which must have `rank` dimensions.
    Tensor field(const char* name, std::size_t rank) {
        Tensor tensor = std::move(fields[name]);
        const bool empty = std::any_of(tensor.shape.begin(), tensor.shape.end(), [](std::size_t n) { return n == 0; });
        if ((tensor.shape.size() != rank || empty) && wrong.empty())
            wrong = "field '" + std::string(name) + "' is missing or not an array of " + std::to_string(rank) +
                    " dimensions";
        tensor.shape.resize(rank);
        // Measured values are far below this limit; products of four such values are still finite floats.
        constexpr float most = 1e9f;
        for (std::size_t i = 0; i < tensor.values.size(); ++i) {
            if (std::abs(tensor.values[i]) <= most) continue;
            tensor.values[i] = 0;
            if (bad++ == 0) first_bad = "number " + std::to_string(i + 1) + " of '" + name + "'";
        }
        return tensor;
    }
};

/// Spectra of `area` points for each of some slices, as colours: the sums of their values, weighted by wavelength.
std::vector<Rgb> colors_of(const Tensor& spectra, const std::vector<RgbD>& weights, std::size_t slices,
                           std::size_t area) {
    std::vector<Rgb> colors(slices * area);
    for (std::size_t s = 0; s < slices; ++s)
        for (std::size_t i = 0; i < area; ++i) {
            RgbD sum;
            for (std::size_t w = 0; w < weights.size(); ++w)
                sum += weights[w] * static_cast<double>(spectra.values[(s * weights.size() + w) * area + i]);
            colors[s * area + i] = {static_cast<Real>(std::max(sum.r, 0.0)), static_cast<Real>(std::max(sum.g, 0.0)),
                                    static_cast<Real>(std::max(sum.b, 0.0))};
        }
    return colors;
}

}  // namespace

Result<std::shared_ptr<const MeasuredReflectance>> MeasuredReflectance::read(const std::string& path,
                                                                             const ColorContext& color) {
    auto fields = read_tensor_file(path);
    if (!fields) return fields.error();
    FieldReader reader{*fields, {}, {}, 0};
    std::string& wrong = reader.wrong;
    const Tensor theta = reader.field("theta_i", 1), phi = reader.field("phi_i", 1),
                 wavelengths = reader.field("wavelengths", 1), normals = reader.field("ndf", 2),
                 sigma = reader.field("sigma", 2);
    Tensor visible = reader.field("vndf", 4), luminance = reader.field("luminance", 4);
    const Tensor spectra = reader.field("spectra", 5);
    const std::size_t slices = theta.shape[0] * phi.shape[0], waves = wavelengths.shape[0];
    const auto of_slices = [&](const Tensor& t) { return t.shape[0] == phi.shape[0] && t.shape[1] == theta.shape[0]; };
    const auto a_grid = [](const Tensor& t) {
        return t.shape[t.shape.size() - 1] >= 2 && t.shape[t.shape.size() - 2] >= 2;
    };
    if (wrong.empty() &&
        !(of_slices(visible) && of_slices(luminance) && of_slices(spectra) && spectra.shape[2] == waves))
        wrong = "'vndf', 'luminance' and 'spectra' do not fit 'phi_i', 'theta_i' and 'wavelengths'";
    if (wrong.empty())
        for (const Tensor* t :
             {&normals, &sigma, static_cast<const Tensor*>(&visible), static_cast<const Tensor*>(&luminance), &spectra})
            if (!a_grid(*t)) wrong = "a table has fewer than two rows or columns";
    for (const Tensor* t : {&theta, &phi, &wavelengths})
        for (std::size_t i = 1; i < t->values.size() && wrong.empty(); ++i)
            if (!(t->values[i] > t->values[i - 1])) wrong = "'theta_i', 'phi_i' or 'wavelengths' do not ascend";
    if (!wrong.empty())
        return error_at({path, 0, 0}, wrong + "; expected a measured material in RGL's format (spectral)");
    for (Tensor* t : {&visible, &luminance})
        for (float& value : t->values) value = std::max(value, 0.0f);

    auto made = std::make_shared<MeasuredReflectance>();
    made->isotropic_ = phi.shape[0] <= 2;
    made->theta_ = theta.values;
    made->phi_ = phi.values;
    made->normals_ = {normals.shape[0], normals.shape[1], normals.values};
    made->sigma_ = {sigma.shape[0], sigma.shape[1], sigma.values};
    made->visible_normals_ = {std::move(visible.values), slices, visible.shape[2], visible.shape[3]};
    made->luminance_ = {std::move(luminance.values), slices, luminance.shape[2], luminance.shape[3]};
    made->rows_ = spectra.shape[3];
    made->columns_ = spectra.shape[4];
    const std::vector<RgbD> weights =
        reflectance_weights({wavelengths.values.begin(), wavelengths.values.end()}, color);
    made->spectra_ = colors_of(spectra, weights, slices, made->rows_ * made->columns_);
    made->tabulate_albedo();
    if (reader.bad > 0)
        made->warning = std::to_string(reader.bad) + (reader.bad == 1 ? " value" : " values") +
                        " not finite or beyond 1e9, first " + reader.first_bad + "; taken as 0";
    return std::shared_ptr<const MeasuredReflectance>(std::move(made));
}

}  // namespace raylex::transport
