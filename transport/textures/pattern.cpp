#include "transport/textures/pattern.h"

#include "transport/textures/procedural_patterns.h"
#include "transport/textures/tee.h"
#include "transport/textures/texture_mapping.h"

namespace raylex::transport {
Registry<PatternFactory>& pattern_registry() {
    static Registry<PatternFactory> registry = [] {
        using enum ParameterType;
        Registry<PatternFactory> r("texture");
        r.add({"constant", "one value everywhere", {{"value", spectrum, "1", "a colour or a number"}}, {}});
        r.add({"scale",
               "a texture times a number",
               {{"tex", texture, "1", "the texture to scale"}, {"scale", texture, "1", "a number or float texture"}},
               {}});
        r.add({"mix",
               "a blend of two textures",
               {{"tex1", texture, "0", "at amount 0"},
                {"tex2", texture, "1", "at amount 1"},
                {"amount", texture, "0.5", "0 to 1"}},
               {}});
        r.add({"checkerboard",
               "two textures in alternating squares",
               with_mapping({{"tex1", texture, "1", "one"},
                             {"tex2", texture, "0", "the other"},
                             {"dimension", integer, "2", "2 or 3"}}),
               {}});
        r.add(
            {"imagemap",
             "an image",
             with_mapping({{"filename", string, "", "PNG, EXR, HDR, PFM, JPEG or TGA"},
                           {"encoding", string, "", "sRGB, linear or gamma N; the default depends on the file format"},
                           {"wrap", string, "repeat", "repeat, black, clamp or octahedralsphere"},
                           {"filter", string, "bilinear", "bilinear, point, trilinear, EWA or unfiltered"},
                           {"maxanisotropy", real, "8", "for EWA: longer ellipses are widened"},
                           {"scale", real, "1", "factor on the values"},
                           {"invert", boolean, "false", "1 minus the values"}}),
             {}});
        r.add(tee_entry());
        register_procedural_patterns(r);
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
