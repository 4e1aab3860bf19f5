// The interface with which a plugin registers its objects: the program's own registries, which built-in objects use
// too.
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

/// One object registered by a plugin, as `raylex plugins` and `--help` list it.
struct PluginEntry {
    std::string kind;  ///< "integrator", "material", ...
    std::string name, help;
    std::vector<ParameterDescription> parameters;
    bool shadows = false;  ///< replaces a built-in object of that name
};

/// The argument of a plugin's entry point, which runs once, before anything is parsed or rendered. An entry is a name,
/// one line of help, the typed parameters, and a factory; its parameters are checked like those of built-in objects. A
/// name of a built-in object replaces that object. A name of another plugin's object is refused, together with the
/// whole plugin.
class PluginHost {
  public:
    /// `taken` contains the entries of the plugins loaded before.
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
    /// Adds a plain channel to which this plugin's objects write. A render contains it if the user requests it by name,
    /// as a geometric AOV (`--aov NAME`). `help` is one line. Names of raylex's own channels are refused.
    void add_channel(display::ChannelDefinition channel, std::string help);
    /// Adds a row to the event table for a material's own lobe, by which light path expressions match it. `lobe.name`
    /// must live as long as the program. Adding the same row again returns the same id.
    LobeId add_lobe(const LobeKind& lobe);
    /// Refuses this plugin with a reason, and removes everything that it registered.
    void refuse(std::string reason);

    [[nodiscard]] const std::vector<PluginEntry>& entries() const { return entries_; }
    [[nodiscard]] const std::optional<std::string>& refusal() const { return refusal_; }
    /// Restores every registry to its previous state.
    void take_back();

  private:
    template <class Factory>
    void add(Registry<Factory>& registry, typename Registry<Factory>::Entry entry);
    std::vector<PluginEntry> taken_, entries_;
    std::optional<std::string> refusal_;
    std::vector<std::function<void()>> undo_;
};

}  // namespace raylex::transport
