// The stamp of a plugin: RAYLEX_PLUGIN writes it into a section of the file, and plugin_loader.h reads it from the
// file. No code of a plugin runs, not even its static constructors, before its stamp has matched the program's own.
//
// C++ objects cross the border in both directions, so everything that determines their layout and meaning must agree:
// raylex's version and headers, the binary interfaces of the compiler and the standard library, and the resulting
// sizes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/integrators/integrator.h"
#include "transport/plugins/interface.h"

#define RAYLEX_PLUGIN_TEXT_OF(x) #x
#define RAYLEX_PLUGIN_TEXT(x) RAYLEX_PLUGIN_TEXT_OF(x)

namespace raylex::transport {

/// Plain text and numbers. `magic` and `version` have the same offsets in every version of raylex.
struct PluginStamp {
    static constexpr std::string_view section = "raylex_plugin";
    static constexpr std::string_view magic_text = "raylex plugin, form 1";
    static constexpr std::size_t layout_count = 12;

    std::array<char, 24> magic{};
    std::array<char, 24> version{};                    ///< of raylex
    std::array<char, 48> compiler{};                   ///< and its version of the C++ binary interface
    std::array<char, 48> standard_library{};           ///< and the options that change its layout
    std::array<char, 72> interface {};                 ///< digest of raylex's headers
    std::array<std::uint32_t, layout_count> layout{};  ///< sizes of the objects that cross the border
};

inline constexpr std::array<const char*, PluginStamp::layout_count> plugin_layout_names{
    "std::string", "std::vector", "std::function", "ParameterSet", "SampleTable", "DisplayServices",
    "LpeServices", "Tracker",     "Bsdf",          "SurfacePoint", "Registry",    "IntegratorContext"};

namespace plugin_detail {

template <std::size_t Size>
constexpr std::array<char, Size> padded(std::string_view text) {
    std::array<char, Size> result{};
    for (std::size_t i = 0; i < text.size() && i + 1 < Size; ++i) result[i] = text[i];
    return result;
}

}  // namespace plugin_detail

/// The stamp of the code that is being compiled.
constexpr PluginStamp make_plugin_stamp() {
    using plugin_detail::padded;
    PluginStamp stamp;
    stamp.magic = padded<24>(PluginStamp::magic_text);
    stamp.version = padded<24>(RAYLEX_PLUGIN_VERSION);
#if defined(__clang__)
    stamp.compiler =
        padded<48>("Clang " RAYLEX_PLUGIN_TEXT(__clang_major__) ", C++ ABI " RAYLEX_PLUGIN_TEXT(__GXX_ABI_VERSION));
#else
    stamp.compiler = padded<48>("g++ " RAYLEX_PLUGIN_TEXT(__GNUC__) ", C++ ABI " RAYLEX_PLUGIN_TEXT(__GXX_ABI_VERSION));
#endif
#if defined(_GLIBCXX_DEBUG)
    stamp.standard_library = padded<48>("libstdc++ with _GLIBCXX_DEBUG");
#elif defined(__GLIBCXX__)
    stamp.standard_library = padded<48>("libstdc++, string ABI " RAYLEX_PLUGIN_TEXT(_GLIBCXX_USE_CXX11_ABI));
#else
    stamp.standard_library = padded<48>("another standard library than libstdc++");
#endif
    stamp.interface = padded<72>(RAYLEX_PLUGIN_INTERFACE);
    stamp.layout = {sizeof(std::string),
                    sizeof(std::vector<float>),
                    sizeof(std::function<void()>),
                    sizeof(ParameterSet),
                    sizeof(display::SampleTable),
                    sizeof(display::DisplayServices),
                    sizeof(display::LpeServices),
                    sizeof(display::Tracker),
                    sizeof(Bsdf),
                    sizeof(SurfacePoint),
                    sizeof(Registry<IntegratorFactory>),
                    sizeof(IntegratorContext)};
    return stamp;
}

}  // namespace raylex::transport
