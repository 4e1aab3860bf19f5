// The lobes of the in-tree materials: rows of the normative event table, by name.
#pragma once

#include <array>

#include "transport/materials/bsdf/bsdf.h"

namespace raylex::transport::lobes {

// A lobe is singular (S) when it is a Dirac delta, which for microfacets means alpha < Ggx::smooth_below on both axes.
inline constexpr LobeId diffuse = 0;                  ///< R D: Lambert, alone, under a coat, or beside a specular lobe
inline constexpr LobeId conductor_glossy = 1;         ///< R G
inline constexpr LobeId conductor_singular = 2;       ///< R S
inline constexpr LobeId glass_reflect_glossy = 3;     ///< R G: dielectric
inline constexpr LobeId glass_reflect_singular = 4;   ///< R S: dielectric, thindielectric
inline constexpr LobeId glass_transmit_glossy = 5;    ///< T G
inline constexpr LobeId glass_transmit_singular = 6;  ///< T S
inline constexpr LobeId coat_glossy = 7;              ///< R G: light that never entered the coat
inline constexpr LobeId coat_singular = 8;            ///< R S
inline constexpr LobeId specular_glossy = 9;          ///< R G: the GGX lobe of raylex:additive
inline constexpr LobeId mirror = 10;                  ///< R S: ideal reflection of constant reflectance
inline constexpr LobeId sheet = 11;              ///< T S: index-matched sheet, straight through, an event of its own
inline constexpr LobeId diffuse_transmit = 12;   ///< T D: diffusetransmission
inline constexpr LobeId hair_r = 13;             ///< R G: reflected at the fibre's surface
inline constexpr LobeId hair_tt = 14;            ///< T G: through the fibre
inline constexpr LobeId hair_trt = 15;           ///< R G: reflected once inside the fibre
inline constexpr LobeId hair_trrt = 16;          ///< R G: reflected inside more often
inline constexpr LobeId specular_singular = 17;  ///< R S: the surface of a subsurface material
/// T D: into and out of a subsurface material, smooth or rough. Light that walks at random inside leaves diffusely, and
/// the `subsurface` channels of RenderMan and of the shipped partition count such light.
inline constexpr LobeId subsurface = 18;
inline constexpr LobeId measured = 19;  ///< R G
inline constexpr int count = 20;

// Lobe slots give these names their numbers (D2, S4, S8): lpe/channels/lobe_slots.h.
inline constexpr std::array<LobeKind, count> kinds{{
    {lpe::EventType::reflection, lpe::Scatter::diffuse, "diffuse"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "conductor"},
    {lpe::EventType::reflection, lpe::Scatter::singular, "conductor"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "glass"},
    {lpe::EventType::reflection, lpe::Scatter::singular, "glass"},
    {lpe::EventType::transmission, lpe::Scatter::glossy, "glass"},
    {lpe::EventType::transmission, lpe::Scatter::singular, "glass"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "coat"},
    {lpe::EventType::reflection, lpe::Scatter::singular, "coat"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "specular"},
    {lpe::EventType::reflection, lpe::Scatter::singular, "mirror"},
    {lpe::EventType::transmission, lpe::Scatter::singular, "sheet"},
    {lpe::EventType::transmission, lpe::Scatter::diffuse, "diffuse"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "R"},
    {lpe::EventType::transmission, lpe::Scatter::glossy, "TT"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "TRT"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "TRRT"},
    {lpe::EventType::reflection, lpe::Scatter::singular, "specular"},
    {lpe::EventType::transmission, lpe::Scatter::diffuse, "subsurface"},
    {lpe::EventType::reflection, lpe::Scatter::glossy, "measured"},
}};

constexpr LobeId conductor(bool delta) {
    return delta ? conductor_singular : conductor_glossy;
}
constexpr LobeId coat(bool delta) {
    return delta ? coat_singular : coat_glossy;
}
constexpr LobeId glass(bool transmitted, bool delta) {
    if (transmitted) return delta ? glass_transmit_singular : glass_transmit_glossy;
    return delta ? glass_reflect_singular : glass_reflect_glossy;
}

/// The lobe that takes the place of `lobe` after Bsdf::regularize().
constexpr LobeId regularized(LobeId lobe) {
    switch (lobe) {
        case conductor_singular:
            return conductor_glossy;
        case glass_reflect_singular:
            return glass_reflect_glossy;
        case glass_transmit_singular:
            return glass_transmit_glossy;
        case coat_singular:
            return coat_glossy;
        case specular_singular:
            return specular_glossy;
        default:
            return lobe;
    }
}

}  // namespace raylex::transport::lobes
