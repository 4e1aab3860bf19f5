// The lights of a scene file, with the geometry around them.
#pragma once

#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/lights/light_table.h"

struct Lit {
    raylex::transport::EmbreeScene geometry;
    raylex::transport::LightTable lights;
    std::vector<raylex::Error> warnings;
};

/// `world` follows WorldBegin, which is in line 1 after `options`.
inline raylex::Result<Lit> try_lit(const std::string& world, const std::string& options = {}) {
    namespace transport = raylex::transport;
    auto scene = transport::import_pbrt_text(options + "WorldBegin\n" + world, "test.pbrt");
    if (!scene) return scene.error();
    transport::TextureTable textures;
    auto geometry = transport::EmbreeScene::build(*scene, textures, {});
    if (!geometry) return geometry.error();
    std::vector<raylex::Error> warnings;
    auto lights = transport::LightTable::build(*scene, *geometry, warnings);
    if (!lights) return lights.error();
    return Lit{*std::move(geometry), *std::move(lights), std::move(warnings)};
}

inline Lit lit(const std::string& world, const std::string& options = {}) {
    auto made = try_lit(world, options);
    INFO((made ? std::string() : made.error().to_string()));
    REQUIRE(made.ok());
    return *std::move(made);
}
