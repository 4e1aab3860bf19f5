// The header that plugins include. A plugin is one shared library that adds integrators, patterns, materials, lights,
// filters or display drivers. `raylex render --plugin libNAME.so` loads it; its objects are then used by name like
// built-in ones.
//
//     #include "transport/plugins/plugin.h"
//     ... classes ...
//     RAYLEX_PLUGIN(host) {
//         host.add_integrator({"name", "one line of help", {{"samples", ParameterType::integer, "16", "..."}},
//         factory});
//     }
//
//     find_package(raylex REQUIRED COMPONENTS plugin)
//     raylex_add_plugin(name name.cpp)
//
// If the body throws an exception or calls host.refuse(), the plugin is refused and the program ends with a message.
// Plugins are never unloaded. tests/outside/plugins contains an example of each kind.
#pragma once

#include "display/services/channel_settings.h"
#include "transport/embree/embree_scene.h"
#include "transport/materials/material_inputs.h"
#include "transport/math/sampling.h"
#include "transport/paths/first_hits.h"
#include "transport/plugins/plugin_host.h"
#include "transport/plugins/plugin_stamp.h"

/// The entry point, once per plugin; its body registers with the PluginHost& called `host`.
#define RAYLEX_PLUGIN(host)                                                                                    \
    extern "C" {                                                                                               \
    extern __attribute__((section("raylex_plugin"), visibility("default")))                                    \
    const ::raylex::transport::PluginStamp raylex_plugin_stamp;                                                \
    __attribute__((used)) constinit const ::raylex::transport::PluginStamp raylex_plugin_stamp =               \
        ::raylex::transport::make_plugin_stamp();                                                              \
    __attribute__((visibility("default"))) void raylex_register_plugin(::raylex::transport::PluginHost& host); \
    }                                                                                                          \
    void raylex_register_plugin([[maybe_unused]] ::raylex::transport::PluginHost& host)
