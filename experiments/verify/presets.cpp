#include "experiments/verify/presets.h"

#include "display/services/parameters.h"

namespace raylex::experiments {

namespace {

PresetTerm plain(PassNames pass) {
    return {{{pass}}, nullptr, false};
}
PresetTerm shared(PassNames pass) {
    return {{{pass}}, nullptr, true};
}
PresetTerm product(std::vector<PassNames> added, PassNames times) {
    return {{std::move(added)}, times, false};
}
// Returns a term with one pass, or with its direct and indirect halves.
PresetTerm whole_or_halves(PassNames whole, PassNames direct, PassNames indirect) {
    return {{{whole}, {direct, indirect}}, nullptr, false};
}

// Tolerance relative to the sum of |terms| + |of|. Renderers sum samples sequentially in float, so the error grows with
// their number: at most 2^-24 per sample; Cycles has about a quarter of that. With Cycles 3.4 at 4096 samples,
// Blender's default, it is 3.5e-5 (experiments/docs/verify.md has the figures and the command).
constexpr double accumulation = 4e-5;

// From the Blender manual, Render Passes: Combined = (Dir + Ind) * Col for each kind + Volume + Emit + Env. Light
// groups exist since 3.2. The Denoising Data pass Noisy Image is Combined before denoising. Subsurface was a separate
// kind up to 2.9. 5.0 writes full names.
Preset cycles() {
    const PassNames background = "Env|Environment";
    PresetSplit passes{
        "passes",
        {product({"DiffDir|Diffuse Direct", "DiffInd|Diffuse Indirect"}, "DiffCol|Diffuse Color"),
         product({"GlossDir|Glossy Direct", "GlossInd|Glossy Indirect"}, "GlossCol|Glossy Color"),
         product({"TransDir|Transmission Direct", "TransInd|Transmission Indirect"}, "TransCol|Transmission Color"),
         product({"SubsurfaceDir|Subsurface Direct", "SubsurfaceInd|Subsurface Indirect"},
                 "SubsurfaceCol|Subsurface Color"),
         {{{"VolumeDir|Volume Direct", "VolumeInd|Volume Indirect"}}, nullptr, false},
         shared("Emit|Emission"),
         shared(background)},
        nullptr};
    return {"cycles",
            "Cycles (Blender)",
            "Noisy Image|Combined",
            {std::move(passes), {"light groups", {}, "Combined"}},
            {0, accumulation, "Cycles' float sum of samples, measured at 4096 samples", false},
            "cycles.*.samples",
            background,
            "A denoised Combined is not the sum of its passes; the pass Denoising Data keeps the image before "
            "denoising as Noisy Image, which is checked instead. Light groups sum to Combined if every lamp, emitter "
            "and the world is in a group. Passes of 3.4 lose light of glossy surfaces seen through a volume"};
}

// From the RenderMan documentation, Light Path Expressions: basic and per-lobe channels.
Preset renderman() {
    PresetSplit basic{"passes",
                      {plain("directDiffuse"), plain("indirectDiffuse"), plain("subsurface"), plain("directSpecular"),
                       plain("indirectSpecular"), plain("transmissive"), plain("volume"), shared("emissive")},
                      nullptr};
    PresetSplit lobes{"lobes", {}, nullptr};
    for (PassNames lobe : {"directDiffuseLobe", "indirectDiffuseLobe", "subsurfaceLobe", "directSpecularPrimaryLobe",
                           "indirectSpecularPrimaryLobe", "directSpecularRoughLobe", "indirectSpecularRoughLobe",
                           "directSpecularClearcoatLobe", "indirectSpecularClearcoatLobe",
                           "directSpecularIridescenceLobe", "indirectSpecularIridescenceLobe", "directSpecularFuzzLobe",
                           "indirectSpecularFuzzLobe", "transmissiveSingleScatterLobe", "directSpecularGlassLobe",
                           "indirectSpecularGlassLobe", "transmissiveGlassLobe"})
        lobes.terms.push_back(plain(lobe));
    lobes.terms.push_back(shared("emissive"));
    return {"renderman",
            "RenderMan",
            "beauty|Ci|rgba",
            {std::move(basic), std::move(lobes)},
            {0, accumulation, "the float sum of samples, as measured with Cycles at 4096 samples", false},
            nullptr,
            nullptr,
            "Sample filters, clamps and tone mapping that act on the beauty alone, denoising, and light in volumes "
            "(missing from the basic channels) break the sum"};
}

// From the Arnold User Guide, AOVs and Light Path Expression AOVs. RGBA_default is the group of lights without a group.
Preset arnold() {
    PresetSplit scattering{
        "scattering",
        {whole_or_halves("diffuse", "diffuse_direct", "diffuse_indirect"),
         whole_or_halves("specular", "specular_direct", "specular_indirect"),
         whole_or_halves("coat", "coat_direct", "coat_indirect"),
         whole_or_halves("sheen", "sheen_direct", "sheen_indirect"),
         whole_or_halves("transmission", "transmission_direct", "transmission_indirect"),
         whole_or_halves("sss", "sss_direct", "sss_indirect"),
         whole_or_halves("volume", "volume_direct", "volume_indirect"), shared("emission"), shared("background")},
        nullptr};
    return {"arnold",
            "Arnold",
            "RGBA|beauty|C",
            {std::move(scattering),
             {"direct and indirect",
              {plain("direct"), plain("indirect"), shared("emission"), shared("background")},
              nullptr},
             {"light groups", {}, "RGBA"}},
            {0, accumulation, "the float sum of samples, as measured with Cycles at 4096 samples", false},
            nullptr,
            nullptr,
            "A clamp that affects AOVs differently, imagers and denoising break the sum. Light groups sum to RGBA only "
            "with RGBA_default, the lights without a group"};
}

// From the V-Ray documentation, Back to Beauty: the basic formula and that of raw elements. Names as written by 3ds
// Max, Maya and Nuke.
Preset vray() {
    const std::vector<PresetTerm> common{
        shared("specular"), shared("SSS|SSS2|subsurfaceScattering|FastSSS2"), shared("selfIllum|selfIllumination"),
        shared("caustics"), shared("atmosphere|atmos|atmosphericEffects"),    shared("background")};
    PresetSplit basic{"elements",
                      {plain("lighting|light"), plain("GI|globalIllumination"), plain("reflection|reflect"),
                       plain("refraction|refract")},
                      nullptr};
    PresetSplit raw{"raw elements",
                    {product({"rawLight|rawLighting", "rawGI|rawGlobalIllumination"}, "diffuseFilter|diffuse"),
                     product({"rawReflection|rawReflect"}, "reflectionFilter|reflectFilter"),
                     product({"rawRefraction|rawRefract"}, "refractionFilter|refractFilter")},
                    nullptr};
    for (PresetSplit* split : {&basic, &raw}) split->terms.insert(split->terms.end(), common.begin(), common.end());
    return {"vray",
            "V-Ray",
            "RGB_color|rgb|rgba|beauty",
            {std::move(basic), std::move(raw)},
            {0, accumulation, "the float sum of samples, as measured with Cycles at 4096 samples", false},
            nullptr,
            nullptr,
            "Color mapping, clamped output, Affect Channels: All, denoising, and a composited background break the "
            "sum; raw elements do not multiply to the beauty under motion blur and depth of field"};
}

}  // namespace

std::span<const Preset> presets() {
    static const std::vector<Preset> all{cycles(), renderman(), arnold(), vray()};
    return all;
}

Result<const Preset*> find_preset(const std::string& name) {
    std::vector<std::string> names;
    for (const Preset& preset : presets()) {
        if (preset.name == name) return &preset;
        names.emplace_back(preset.name);
    }
    std::string list;
    for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
    return error_at({"--preset", 0, 0}, "no preset '" + name + "'; expected one of: " + list, near_miss(name, names));
}

}  // namespace raylex::experiments
