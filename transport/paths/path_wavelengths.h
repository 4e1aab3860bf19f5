// The wavelengths of a batch of subpaths, for scenes in which an index of refraction depends on them.
//
// Each sample has one wavelength (color/wavelengths.h), shared by its camera and its light subpath. A subpath carries
// all colours until it meets such an interface (Subpath::one_wavelength). From there on it is refracted by the index of
// its wavelength, and its light is multiplied by the wavelength's weight, once for a whole path however many subpaths
// make it. Throughputs leave the weight out: roulette, sampled distances and splits depend on them, and weights may be
// negative.
//
// What an ideal interface reflects on the side of the lesser index goes one way at all wavelengths. It has the colour
// of Fresnel's share at the mean index of each primary, as metals have (within 1e-4 of the mean over the wavelengths
// for heavy flint), and no wavelength is needed for it: a path that only looks at itself in a window has no noise of
// colour. The mean index chooses between the two lobes there; what is refracted has the share of its wavelength.
#pragma once

#include <span>
#include <vector>

#include "transport/paths/event_table.h"
#include "transport/paths/scattering.h"
#include "transport/paths/subpath.h"
#include "transport/paths/vertex.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

class PathWavelengths {
  public:
    PathWavelengths(const SceneView& scene, std::size_t capacity)
        : scene_(scene), heroes_(scene.wavelengths != nullptr ? capacity : 0) {}

    [[nodiscard]] bool any() const { return scene_.wavelengths != nullptr; }
    /// Draws the wavelengths of rows [0, samplers.size()).
    void draw(std::span<const PixelSampler> samplers) {
        for (std::size_t row = 0; row < samplers.size(); ++row)
            heroes_[row] = scene_.wavelengths->draw(samplers[row].get_1d(wavelength_dimension));
    }
    /// The weight of the row's wavelength, for paths of one wavelength.
    [[nodiscard]] const Rgb& weight(std::uint32_t row) const { return heroes_[row].weight; }
    [[nodiscard]] Rgb throughput(std::uint32_t row, const Subpath& path) const {
        return path.one_wavelength ? path.beta * weight(row) : path.beta;
    }

    /// Where the index of refraction of a vertex depends on the wavelength, sets the index of the subpath's wavelength
    /// in the closure and marks the subpath. Skips interfaces that reflect all wavelengths alike: leave() handles
    /// these.
    [[gnu::noinline]] void meet(VertexBatch& vertices, std::span<Subpath> paths) const {
        for (std::size_t j = 0; j < vertices.surfaces; ++j) {
            const SurfacePoint& point = vertices.points[j];
            const IndexSpectrum* index = scene_.materials->index_spectrum(*scene_.textures, point);
            if (index == nullptr || vertices.bsdfs[j].reflects_all_alike(*index, point.wo)) continue;
            vertices.bsdfs[j].set_index(index->at(heroes_[vertices.rows[j]].nm));
            paths[vertices.rows[j]].one_wavelength = true;
        }
    }
    /// Applies the wavelength of a subpath that leaves vertex j by `s`, at interfaces that meet() skipped.
    template <TransportMode mode>
    [[gnu::noinline]] void leave(const VertexBatch& vertices, std::size_t j, Subpath& path, BsdfSample& s) const {
        if (j >= vertices.surfaces || !(s.pdf > 0)) return;
        const SurfacePoint& point = vertices.points[j];
        const IndexSpectrum* index = scene_.materials->index_spectrum(*scene_.textures, point);
        if (index == nullptr || !vertices.bsdfs[j].reflects_all_alike(*index, point.wo)) return;
        if (!s.transmitted) {
            s.weight *= vertices.bsdfs[j].reflected_colours(index->mean(), point.wo);
            return;
        }
        Bsdf refracting = vertices.bsdfs[j];
        refracting.set_index(index->at(heroes_[vertices.rows[j]].nm));
        refracting.keep_side(Sides::transmission);
        const Real chance = s.pdf;
        s = sample_scattering<mode>(refracting, point, 0, {});
        s.weight *= 1 / chance;
        s.pdf = chance;
        path.one_wavelength = true;
    }

  private:
    const SceneView scene_;
    std::vector<HeroWavelength> heroes_;  // by row
};

}  // namespace raylex::transport
