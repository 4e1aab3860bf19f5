#include "transport/materials/pattern.h"

#include "transport/materials/tee.h"

namespace raylex::transport {
namespace {

thread_local display::DisplayServices* current = nullptr;

}  // namespace

display::DisplayServices* shading_display() { return current; }

ShadingScope::ShadingScope(display::DisplayServices* services) { current = services; }
ShadingScope::~ShadingScope() { current = nullptr; }

Registry<PatternFactory>& pattern_registry() {
    static Registry<PatternFactory> registry = [] {
        using enum ParameterType;
        Registry<PatternFactory> r("texture");
        const ParameterDescription u_scale{"uscale", real, "1", "and vscale, udelta, vdelta, mapping, v1, v2: as pbrt-v4"};
        r.add({"constant", "one value everywhere", {{"value", spectrum, "1", "a colour or a number"}}, {}});
        r.add({"scale", "a texture times a number",
               {{"tex", texture, "1", "what is scaled"}, {"scale", texture, "1", "a number or float texture"}}, {}});
        r.add({"mix", "two textures blended",
               {{"tex1", texture, "0", "at amount 0"}, {"tex2", texture, "1", "at amount 1"}, {"amount", texture, "0.5", "0 to 1"}},
               {}});
        r.add({"checkerboard", "two textures by turns",
               {{"tex1", texture, "1", "one"}, {"tex2", texture, "0", "the other"}, {"dimension", integer, "2", "2 or 3"}, u_scale},
               {}});
        r.add({"imagemap", "an image",
               {{"filename", string, "", "PNG, EXR, HDR, PFM, JPEG or TGA"},
                {"encoding", string, "", "sRGB, linear or gamma N; default by the kind of file"},
                {"wrap", string, "repeat", "repeat, black, clamp or octahedralsphere"},
                {"filter", string, "bilinear", "bilinear or point"},
                {"scale", real, "1", "times the values"},
                {"invert", boolean, "false", "1 minus the values"},
                u_scale},
               {}});
        r.add(tee_entry());
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
