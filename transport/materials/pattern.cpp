#include "transport/materials/pattern.h"

#include "transport/materials/tee.h"

namespace raylex::transport {
namespace {

thread_local display::DisplayServices* current = nullptr;

}  // namespace

display::DisplayServices* shading_display() {
    return current;
}

ShadingScope::ShadingScope(display::DisplayServices* services) {
    current = services;
}
ShadingScope::~ShadingScope() {
    current = nullptr;
}

Registry<PatternFactory>& pattern_registry() {
    static Registry<PatternFactory> registry = [] {
        using enum ParameterType;
        Registry<PatternFactory> r("texture");
        const auto mapped = [](std::vector<ParameterDescription> parameters) {
            parameters.insert(parameters.end(), {{"mapping", string, "uv", "uv, spherical, cylindrical or planar"},
                                                 {"uscale", real, "1", "times u, for uv"},
                                                 {"vscale", real, "1", "times v, for uv"},
                                                 {"udelta", real, "0", "added to u, for uv and planar"},
                                                 {"vdelta", real, "0", "added to v, for uv and planar"},
                                                 {"v1", vector3, "1 0 0", "u grows along it, for planar"},
                                                 {"v2", vector3, "0 1 0", "v grows along it, for planar"}});
            return parameters;
        };
        r.add({"constant", "one value everywhere", {{"value", spectrum, "1", "a colour or a number"}}, {}});
        r.add({"scale",
               "a texture times a number",
               {{"tex", texture, "1", "what is scaled"}, {"scale", texture, "1", "a number or float texture"}},
               {}});
        r.add({"mix",
               "two textures blended",
               {{"tex1", texture, "0", "at amount 0"},
                {"tex2", texture, "1", "at amount 1"},
                {"amount", texture, "0.5", "0 to 1"}},
               {}});
        r.add({"checkerboard",
               "two textures by turns",
               mapped({{"tex1", texture, "1", "one"},
                       {"tex2", texture, "0", "the other"},
                       {"dimension", integer, "2", "2 or 3"}}),
               {}});
        r.add({"imagemap",
               "an image",
               mapped({{"filename", string, "", "PNG, EXR, HDR, PFM, JPEG or TGA"},
                       {"encoding", string, "", "sRGB, linear or gamma N; default by the kind of file"},
                       {"wrap", string, "repeat", "repeat, black, clamp or octahedralsphere"},
                       {"filter", string, "bilinear", "bilinear or point"},
                       {"scale", real, "1", "times the values"},
                       {"invert", boolean, "false", "1 minus the values"}}),
               {}});
        r.add(tee_entry());
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
