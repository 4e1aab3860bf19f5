// What a plugin registers with: the program's own registries, through which every in-tree object came in too.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "display/buffer/pixel_filter.h"
#include "display/drivers/display_driver.h"
#include "display/filters/display_filter.h"
#include "display/services/samples/sample_filter.h"
#include "transport/cameras/camera.h"
#include "transport/import/shapes/shapes.h"
#include "transport/integrators/integrator.h"
#include "transport/lights/light_table.h"
#include "transport/materials/material.h"
#include "transport/media/medium.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {

/// One object that a plugin registered, as `raylex plugins` and `--help` show it.
struct PluginEntry {
    std::string kind;  ///< "integrator", "material", ...
    std::string name, help;
    std::vector<ParameterDescription> parameters;
    bool shadows = false;  ///< takes the place of an in-tree object of that name
};

/// Handed to a plugin's entry point, once, before anything is parsed or rendered. An entry is a name, one line of help,
/// the typed parameters, and a factory; its parameters are judged as those of in-tree objects are. A name that is taken
/// in-tree is replaced; one that another plugin has taken is refused, and the whole plugin with it.
class PluginHost {
  public:
    /// `taken` is what the plugins before this one registered.
    explicit PluginHost(std::vector<PluginEntry> taken);

    void add_integrator(Registry<IntegratorFactory>::Entry entry);
    void add_camera(Registry<CameraFactory>::Entry entry);
    void add_material(Registry<MaterialFactory>::Entry entry);
    void add_pattern(Registry<PatternFactory>::Entry entry);
    void add_medium(Registry<MediumFactory>::Entry entry);
    void add_shape(Registry<ShapeFactory>::Entry entry);
    void add_light(Registry<LightFactory>::Entry entry);
    void add_pixel_filter(Registry<display::PixelFilterFactory>::Entry entry);
    void add_sample_filter(Registry<display::SampleFilterFactory>::Entry entry);
    void add_display_filter(Registry<display::DisplayFilterFactory>::Entry entry);
    void add_display_driver(Registry<display::DisplayDriverFactory>::Entry entry);
    /// A plain channel that this plugin's objects write to. A render has it when the user requests it by name, as a
    /// geometric AOV (`--aov NAME`). `help` is one line. A name of raylex's own is refused.
    void add_channel(display::ChannelDefinition channel, std::string help);
    /// A row of the event table for a material's own lobe: what light path expressions match it by. `lobe.name` must
    /// live as long as the program. The same row again gives the same id.
    LobeId add_lobe(const LobeKind& lobe);
    /// Says why this plugin cannot work here. Everything it registered is taken back.
    void refuse(std::string reason);

    [[nodiscard]] const std::vector<PluginEntry>& entries() const { return entries_; }
    [[nodiscard]] const std::optional<std::string>& refusal() const { return refusal_; }
    /// Puts every registry back to what it was.
    void take_back();

  private:
    template <class Factory>
    void add(Registry<Factory>& registry, typename Registry<Factory>::Entry entry);
    std::vector<PluginEntry> taken_, entries_;
    std::optional<std::string> refusal_;
    std::vector<std::function<void()>> undo_;
};

}  // namespace raylex::transport
