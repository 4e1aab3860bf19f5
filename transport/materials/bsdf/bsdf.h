// Results of scattering at a point: values, samples and the lobes that they belong to.
//
// Every result lists the contribution of each lobe, so that a path can be attributed exactly (Law 5).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "lpe/event.h"
#include "transport/math/real.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// Index into lobe_kinds(): one row of the normative event table (lpe/README.md).
using LobeId = std::uint8_t;

struct LobeKind {
    lpe::EventType type = lpe::EventType::reflection;
    lpe::Scatter scatter = lpe::Scatter::diffuse;
    const char* name = "";  ///< the lobe's label, by which lobe slots number it: "diffuse", "conductor", ...
};

/// All lobes that any registered material can give, in LobeId order: those of the in-tree materials, then plugins'.
std::span<const LobeKind> lobe_kinds();
/// Adds the row of a plugin's lobe, before any scene is built, and returns its id: the known one if the row exists,
/// nothing if all 256 are taken. `lobe.name` must outlive every use.
std::optional<LobeId> add_lobe(const LobeKind& lobe);

inline constexpr int max_lobes = 4;

/// Value of one lobe: f |cos|, its share of the whole.
struct LobeValue {
    LobeId lobe = 0;
    Rgb value;
};

/// Every scattering returns such a list, and most lists have one entry: only entries in use are constructed and copied.
struct LobeList {
    union {
        std::array<LobeValue, max_lobes> entry;
    };
    int count = 0;

    LobeList() {}
    LobeList(const LobeList& other) { *this = other; }
    LobeList& operator=(const LobeList& other) {
        const int entries = other.count;
        for (count = 0; count < entries;) {  // correct for self-assignment too
            const LobeValue& lobe = other.entry[static_cast<std::size_t>(count)];
            add(lobe.lobe, lobe.value);
        }
        return *this;
    }
    void add(LobeId lobe, const Rgb& value) {
        LobeValue& one = entry[static_cast<std::size_t>(count++)];
        one.lobe = lobe;
        one.value.r = value.r;  // one by one, or compilers copy what they have just stored (math/make_at.h)
        one.value.g = value.g;
        one.value.b = value.b;
    }
};

/// f(wo, wi) |cos theta_i| over all non-delta lobes, and the density with which sample() would choose wi (per
/// steradian).
struct BsdfEvaluation {
    Rgb value;
    Real pdf = 0;
    LobeList lobes;  ///< their values sum to `value`
};

struct BsdfSample {
    Vec3 wi;
    Rgb weight;      ///< f |cos| / pdf over all lobes that could have produced wi
    Real pdf = 0;    ///< per steradian; 0 marks failure (path ends); for delta lobes the discrete probability
    LobeList lobes;  ///< the lobes' parts of f |cos|; for a delta lobe just that one
    Real eta = 1;    ///< relative index crossed; 1 unless transmitted through an interface
    bool delta = false;
    bool transmitted = false;
    bool pdf_is_proportional = false;  ///< stochastic (layered) closures: `pdf` belongs to `weight`; MIS uses pdf()
    bool is_weighed = false;           ///< of a DirectionSampler: `weight` and `lobes` are set, for paths of radiance
    /// Of a DirectionSampler: its density over the closure's. Roulette multiplies the throughput by it, since a
    /// direction that is drawn more often than by the closure is no less worth following. Footprints use
    /// the closure's density.
    Real favoured = 1;
    /// Of a DirectionSampler: the density with which the direction was drawn, divided by `pdf`. It differs from 1 only
    /// where `pdf` is a weight and not the density.
    Real drawn_over_pdf = 1;
};

}  // namespace raylex::transport
