// An integrator, a pattern, a material and a sample filter that use the display services as their documents describe
// them: check_promises.cpp renders with them and looks at the files.
#include <array>
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

/// Each camera ray meets surfaces of a made-up stack, as the parameter `mode` chooses. No light is traced.
class Promises final : public Integrator {
  public:
    explicit Promises(std::string mode) : mode_(std::move(mode)) {}
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.saved_state = SavedState::none;
        traits.raster_splats = mode_.starts_with("raster");
        return traits;
    }
    [[nodiscard]] bool synchronous() const override { return mode_.starts_with("raster"); }
    Status prepare(const IntegratorContext& context) override { return context_ = context, success(); }
    void begin_iteration(std::uint64_t iteration) override { iteration_ = iteration; }

    void integrate(const CameraBatch& camera, IntegratorThread&, ThreadServices& services) const override {
        if (mode_.starts_with("raster")) return splat_anywhere(camera, services);
        const auto channels = services.display.get_display_channels();
        const auto id = [&](const char* name) { return display::find_channel(channels, name); };
        for (int row = 0; row < static_cast<int>(camera.rays.size()); ++row) {
            services.display.write(id("heat"), row, 0.25f);
            services.display.splat(id("heat"), row, 0.5f);  // onto what was written
            services.display.splat(id("spots"), row, raylex::Rgb(1, 2, 3));
            services.display.write(id("where"), row, raylex::Rgb(4, 5, 6));
            services.display.write(id("number"), row, std::int32_t{7});
            services.display.write(id("nobody_requested_this"), row, 1.0f);
            if (mode_ == "stack" || mode_ == "stack_first")
                report_stack(services.display, row, id("N"), id("depth_of"));
        }
    }

  private:
    /// Three surfaces of opacity 0.5 at distances 2, 3 and 4 with different values; or values on the first alone.
    void report_stack(display::DisplayServices& display, int row, display::ChannelId normal,
                      display::ChannelId depth) const {
        display.write_distance(row, 2);
        display.write_opacity(row, 0.5f);
        const int second = display.add_sample(row, {.depth = 3, .opacity = RgbD(0.5)}),
                  third = display.add_sample(row, {.depth = 4, .opacity = RgbD(0.5)});
        display.write(normal, row, raylex::Rgb(0, 0, -1));
        display.write(depth, row, 2.0f);
        if (mode_ == "stack_first") return;
        display.write(normal, second, raylex::Rgb(0, 0, -1));
        display.write(normal, third, raylex::Rgb(0, 0, -1));
        display.write(depth, second, 3.0f);
        display.write(depth, third, 4.0f);
    }

    /// Light 1 everywhere in iterations that count, 400 times as much in those that do not.
    void splat_anywhere(const CameraBatch& camera, ThreadServices& services) const {
        const bool discards = mode_ == "raster_all" || iteration_ % 2 == 1;
        const bool at_once = iteration_ % 4 == 1;
        if (discards && at_once) services.display.discard_iteration();
        constexpr int splats = 10;
        for (std::size_t i = 0; i < camera.rays.size(); ++i) {
            if (discards) services.display.splat(display::invalid_channel, static_cast<int>(i), 1.0f);
            for (int k = 0; k < splats; ++k) {
                const display::CameraRow& row = camera.rows[i];
                display::Tracker path = services.raster->begin(row.screen_x, row.screen_y, row);
                services.raster->lpe().move(path, context_.events->user_terminal());
                services.raster->lpe().contribute(raylex::Rgb((discards ? 400.0f : 1.0f) / splats), {}, path);
            }
        }
        if (discards && !at_once) services.display.discard_iteration();
    }

    std::string mode_;
    IntegratorContext context_;
    std::uint64_t iteration_ = 0;
};

/// Writes the depth of the path to a channel, wherever it is evaluated, and its value to one that a texture names.
class Depths final : public Pattern {
  public:
    Depths(TextureId input, std::string channel) : input_(input), named_(std::move(channel)) {}
    [[nodiscard]] transport::Rgb rgb(const PatternPoint& point) const override {
        const transport::Rgb value = point.rgb(input_);
        if (const VertexServices& at = point.services(); at.display != nullptr) {
            const auto channels = at.display->get_display_channels();
            at.display->splat(deep_.id(channels), at.row, at.camera_sees() ? 0.0f : 1.0f);
            if (at.camera_sees()) at.display->write(named_.id(channels), at.row, to_float(value));
        }
        return value;
    }
    [[nodiscard]] Real real(const PatternPoint& point) const override { return point.real(input_); }

  private:
    TextureId input_;
    display::NamedChannel named_, deep_{"deeper_look_ups"};
};

/// A grey surface that writes how deep in its path the camera ray or a later one has met it.
class Marker final : public Material {
  public:
    void shade(const TextureTable&, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            closures[i].set(Frame::from_normal(points[i].shading_normal), LambertClosure{transport::Rgb(0.5f)});
            if (const VertexServices& at = points[i].services; at.display != nullptr)
                at.display->splat(depth_.id(at.display->get_display_channels()), at.row,
                                  static_cast<float>(at.depth + 1));
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override { lobes.push_back(lobes::diffuse); }

  private:
    display::NamedChannel depth_{"depths_met"};
};

/// Fills a channel of its own that nothing else touches.
class Constant final : public display::SampleFilter {
  public:
    explicit Constant(display::ChannelId to) : to_(to) {}
    void apply(display::SampleTable& table) const override {
        for (int row = 0; row < table.camera_row_count(); ++row) table.edit(to_, row)[0] = 3;
    }

  private:
    display::ChannelId to_;
};

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_integrator({"promises",
                         "calls of the display services, without light",
                         {{"mode", ParameterType::string, "flat", "what is reported"}},
                         [](const SceneEntity& entity, auto) -> Result<std::unique_ptr<Integrator>> {
                             ParameterReader reader(entity.parameters);
                             return std::unique_ptr<Integrator>(
                                 std::make_unique<Promises>(reader.string("mode", "flat")));
                         }});
    host.add_pattern({"depths",
                      "its input, and where it is looked up",
                      {{"input", ParameterType::texture, "1", "passed on"},
                       {"channel", ParameterType::string, "", "takes the input, where the camera sees it"}},
                      [](PatternReader& reader) -> Result<std::unique_ptr<Pattern>> {
                          const TextureId input = reader.input("input", 1);
                          return std::unique_ptr<Pattern>(
                              std::make_unique<Depths>(input, reader.string("channel", "")));
                      }});
    host.add_material({"marker", "a grey surface", {}, [](const SceneEntity&, const MaterialContext&) {
                           return Result<std::unique_ptr<Material>>(std::make_unique<Marker>());
                       }});
    host.add_sample_filter(
        {"three",
         "writes 3 to its own channel",
         {},
         [](const ParameterSet&,
            const display::SampleFilterContext& context) -> Result<std::unique_ptr<display::SampleFilter>> {
             const auto to = context.add_channel(display::declared_channel("three", display::ChannelType::real));
             if (!to) return to.error();
             return std::unique_ptr<display::SampleFilter>(std::make_unique<Constant>(*to));
         }});
    host.add_channel(display::declared_channel("deeper_look_ups", display::ChannelType::real),
                     "look-ups behind the first hit");
    host.add_channel(display::declared_channel("depths_met", display::ChannelType::real),
                     "sum of depth + 1 over a path's vertices");
}
