// Helpers of the tests of grid media: media from scene text.
#pragma once

#include <catch2/catch.hpp>

#include "transport/geometry/render_space.h"
#include "transport/import_support.h"
#include "transport/media/medium.h"

namespace grid_media_test {

using namespace raylex::transport;

struct Built {
    SceneDescription scene;
    RenderSpace space;
    std::vector<raylex::Error> warnings;
    MediumTable media;

    [[nodiscard]] const Medium& medium() const { return media[0]; }
    /// The medium at a point of the world.
    [[nodiscard]] MediumPoint at(double x, double y, double z) const { return medium().grid->at(here(x, y, z)); }
    [[nodiscard]] Vec3 here(double x, double y, double z) const { return (DVec3(x, y, z) - space.origin).to_real(); }
    [[nodiscard]] MediumSegment segment(const DVec3& from, const DVec3& to) const {
        return {here(from.x, from.y, from.z), normalize(to - from).to_real(), static_cast<Real>(length(to - from))};
    }
};

inline std::string medium_scene(const std::string& medium, const std::string& transform) {
    return transform + "\nMakeNamedMedium \"fog\" " + medium +
           "\nIdentity MediumInterface \"\" \"fog\"\nCamera \"perspective\"\nWorldBegin\n"
           "MediumInterface \"fog\" \"\" Shape \"sphere\"\n";
}

inline Built build_medium(const std::string& medium, const std::string& transform = "") {
    Built built;
    built.scene = import_test::scene_of(medium_scene(medium, transform));
    built.space = RenderSpace::of(built.scene);
    auto media = MediumTable::build(built.scene, built.warnings, &built.space);
    if (!media) FAIL(media.error().to_string());
    built.media = *std::move(media);
    return built;
}

inline raylex::Error refused_medium(const std::string& medium) {
    const SceneDescription scene = import_test::scene_of(medium_scene(medium, ""));
    const RenderSpace space = RenderSpace::of(scene);
    std::vector<raylex::Error> warnings;
    auto media = MediumTable::build(scene, warnings, &space);
    if (media) FAIL("accepted: " + medium);
    // The scene's alphabet is computed without reading grids, and must reject the parameters that the build rejects.
    return media.error();
}

}  // namespace grid_media_test
