// An integrator that makes random calls of the display services, in whole renders: threads, batches, crops and buckets
// do not affect the result, and discarded calls do not appear. services_model_test.cpp checks the results of calls.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <tuple>

#include "display/buffer/frame_buffer/banded_image.h"
#include "display/deep/deep_buffer.h"
#include "display/services/split_mix.h"
#include "tests/support/folder.h"
#include "transport/integrators/integrator.h"
#include "transport/render_support.h"

using namespace render_test;
using raylex::RgbD;

namespace {

/// Bits that depend only on a camera sample and the number of the call.
std::uint64_t bits_of(const display::CameraRow& row, std::uint64_t call) {
    return raylex::mix_bits(row.sample * raylex::golden_gamma + static_cast<std::uint64_t>(row.pixel_x) * 1000003 +
                            static_cast<std::uint64_t>(row.pixel_y) * 69069 + call * 0xbf58476d1ce4e5b9ull);
}

class RandomCalls final : public transport::Integrator {
  public:
    explicit RandomCalls(bool raster) : raster_(raster) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override {
        transport::IntegratorTraits traits;
        traits.saved_state = transport::SavedState::none;
        traits.raster_splats = traits.pixel_samples = raster_;
        traits.first_hits = true;
        return traits;
    }
    [[nodiscard]] bool synchronous() const override { return raster_; }
    raylex::Status prepare(const transport::IntegratorContext& context) override {
        return context_ = context, raylex::success();
    }
    void begin_iteration(std::uint64_t iteration) override { discards_ = raster_ && iteration % 3 == 1; }
    void integrate(const transport::CameraBatch& camera, transport::IntegratorThread&,
                   transport::ThreadServices& services) const override {
        const bool late = camera.tile % 2 == 0;
        if (discards_ && !late) services.display.discard_iteration();
        // Rays alternate: one call of each after the other.
        for (std::uint64_t n = 0; n < 12; ++n)
            for (std::size_t i = 0; i < camera.rays.size(); ++i) call(static_cast<int>(i), camera.rows[i], n, services);
        if (discards_ && late) services.display.discard_iteration();
    }

  private:
    void call(int row, const display::CameraRow& camera, std::uint64_t n, transport::ThreadServices& services) const {
        display::DisplayServices& display = services.display;
        const std::uint64_t bits = bits_of(camera, n);
        const auto value = static_cast<float>(bits >> 40) * 0x1p-22f;
        const raylex::Rgb color(value, value / 2, 1);
        const auto depth = static_cast<float>(1 + (bits >> 8) % 9);
        const auto id = static_cast<display::ChannelId>((bits >> 16) % 5);
        switch (bits % 8) {
            case 0:
                display.splat(id, row, color);
                break;
            case 1:
                display.write(id, row, color);
                break;
            case 2:
                display.write(id, row, value);
                break;
            case 3:
                display.write_opacity(row, 0.25f * static_cast<float>((bits >> 20) % 5));
                break;
            case 4:
                display.write_distance(row, depth);
                break;
            case 5: {
                const int added = display.add_sample(row, {depth, RgbD(0.5), (bits >> 24) % 2 == 0, 1});
                display.write(id, added, color);
                display.write(id, added, value);
                break;
            }
            case 6:
                if (!raster_) break;
                for (int k = 0; k < 40; ++k)
                    services.raster->lpe().contribute(
                        color, {},
                        services.raster->begin(camera.screen_x, camera.screen_y + 0.01f * static_cast<float>(k),
                                               camera));
                break;
            default:
                services.lpe.contribute(color, {}, services.lpe.begin(row));
        }
    }

    bool raster_, discards_ = false;
    transport::IntegratorContext context_;
};

void register_random_calls() {
    for (const bool raster : {false, true})
        transport::integrator_registry().add(
            {raster ? "test:raster calls" : "test:calls", "for this test", {}, [raster](const auto&, auto) {
                 return raylex::Result<std::unique_ptr<transport::Integrator>>(std::make_unique<RandomCalls>(raster));
             }});
}

transport::RenderSettings settings_of(const char* integrator) {
    register_random_calls();
    transport::RenderSettings settings;
    settings.paths.integrator = transport::SceneEntity{};
    settings.paths.integrator->type = integrator;
    settings.samples.per_pixel = 48;
    settings.machine.threads = 1;
    settings.film.resolution = {{40, 37}};
    for (const auto& [name, type] :
         {std::pair("heat", display::ChannelType::real), std::pair("N", display::ChannelType::normal),
          std::pair("paint", display::ChannelType::rgb), std::pair("near", display::ChannelType::real)}) {
        display::ChannelDefinition channel;
        channel.name = name;
        channel.type = type;
        channel.declared = true;
        if (std::string(name) == "near") channel.rule = display::FilterRule::zmin;
        settings.channels.list.push_back(channel);
    }
    return settings;
}

struct Seen {
    std::vector<double> values;
    std::vector<float> deep;  ///< all deep samples, pixel by pixel; empty without a deep image
    std::uint64_t refused = 0, samples = 0, discarded = 0;
    bool operator==(const Seen&) const = default;
};

/// All data of a region of the image.
Seen seen_of(transport::RenderSettings settings, const display::PixelRegion& region, bool deep) {
    std::unique_ptr<display::DeepBuffer> buffer;
    if (deep)
        settings.before_rendering = [&](const transport::RenderPlan& plan, std::vector<display::SampleSink*>& sinks) {
            buffer = std::make_unique<display::DeepBuffer>(
                plan.width, plan.height, plan.channels, std::vector<display::ChannelId>{0, 1, 2},
                display::DeepOptions{.most_samples = 512, .tolerance = 0x1p-20});
            sinks.push_back(buffer.get());
            return raylex::success();
        };
    const auto output = transport::render(scene_of(room), settings);
    INFO((output ? std::string() : output.error().to_string()));
    REQUIRE(output.ok());
    Seen seen;
    for (display::ChannelId id = 0; id < static_cast<display::ChannelId>(output->image().channels().size()); ++id)
        for (const double v : output->image().resolve(id, region)) seen.values.push_back(v);
    for (const double v : output->image().resolve_alpha(region)) seen.values.push_back(v);
    for (int y = region.y0; deep && y < region.y1; ++y)
        for (int x = region.x0; x < region.x1; ++x)
            for (const display::DeepSample& s : buffer->resolve(x, y)) {
                seen.deep.insert(seen.deep.end(), {s.z, s.z_back, s.alpha});
                seen.deep.insert(seen.deep.end(), s.values.begin(), s.values.end());
            }
    seen.refused = output->statistics.refused_services_calls;
    seen.samples = output->statistics.camera_samples;
    seen.discarded = output->statistics.discarded_samples;
    return seen;
}

const display::PixelRegion whole{0, 0, 40, 37}, part{3, 5, 29, 30};

}  // namespace

TEST_CASE("random calls of a plugin leave the same bits for any thread count, batch, crop and bucket",
          "[render][plugins][law3]") {
    const transport::RenderSettings settings = settings_of("test:calls");
    const Seen once = seen_of(settings, whole, true);
    CHECK(once.refused > 0);
    REQUIRE(once.deep.size() > 40 * 37 * 6);
    transport::RenderSettings other = settings;
    other.machine.threads = 3;
    CHECK(seen_of(other, whole, true) == once);
    // With times of samples each pixel is a separate batch; the channel of times comes last.
    other.channels.list.push_back(aov("cpuTime"));
    Seen by_pixel = seen_of(other, whole, true);
    by_pixel.values.erase(by_pixel.values.end() - 2 * 40 * 37, by_pixel.values.end() - 40 * 37);
    CHECK(by_pixel == once);

    Seen of_part = seen_of(settings, part, true);
    other = settings;
    other.film.crop = part;
    Seen cropped = seen_of(other, part, true);
    CHECK(cropped.samples < of_part.samples);
    CHECK(std::tie(cropped.values, cropped.deep) == std::tie(of_part.values, of_part.deep));

    const raylex::test::Folder folder;
    other = settings;
    other.buckets = transport::BucketSettings{.rows = 16};
    other.checkpoint = transport::CheckpointSettings{};
    other.checkpoint->file = folder.path("buckets");
    other.checkpoint->seconds = std::numeric_limits<double>::infinity();
    const Seen in_buckets = seen_of(other, whole, false);
    CHECK(in_buckets.values == once.values);
}

TEST_CASE("samples that a plugin discards, by any call in any order, appear nowhere", "[render][plugins][law3][gate]") {
    transport::RenderSettings settings = settings_of("test:raster calls");
    const Seen once = seen_of(settings, whole, false);
    CHECK(once.discarded == 16 * 40 * 37);  // the second of three iterations of 16 samples
    CHECK(once.samples == 32 * 40 * 37);
    settings.machine.threads = 3;
    CHECK(seen_of(settings, whole, false) == once);
    // The remaining iterations give the image of a render without the discarded one, except for the samples' numbers. A
    // render of the first iteration alone has its values where nothing else was added.
    settings.samples.per_pixel = 16;
    const Seen first = seen_of(settings, whole, false);
    settings.samples.per_pixel = 32;
    Seen two = seen_of(settings, whole, false);
    CHECK(two.discarded == first.samples);
    two.discarded = first.discarded;
    CHECK(two == first);
}

TEST_CASE("a render whose iterations are all discarded ends with an error", "[render][plugins][law7]") {
    struct Nothing final : transport::Integrator {
        raylex::Status prepare(const transport::IntegratorContext&) override { return raylex::success(); }
        void integrate(const transport::CameraBatch&, transport::IntegratorThread&,
                       transport::ThreadServices& services) const override {
            services.display.discard_iteration();
        }
    };
    transport::integrator_registry().add({"test:nothing", "for this test", {}, [](const auto&, auto) {
                                              return raylex::Result<std::unique_ptr<transport::Integrator>>(
                                                  std::make_unique<Nothing>());
                                          }});
    transport::RenderSettings settings = settings_of("test:nothing");
    const auto output = transport::render(scene_of(room), settings);
    REQUIRE_FALSE(output.ok());
    CHECK(output.error().message.find("discarded all 71040 camera samples") != std::string::npos);
}

TEST_CASE("the renderer supplies what an integrator does not report, with the bits of path", "[render][plugins]") {
    struct Silent final : transport::Integrator {
        raylex::Status prepare(const transport::IntegratorContext&) override { return raylex::success(); }
        void integrate(const transport::CameraBatch& camera, transport::IntegratorThread&,
                       transport::ThreadServices& services) const override {
            for (std::size_t i = 0; i < camera.rays.size(); i += 2)  // every other ray reports an opacity of its own
                if (camera.rows[i].pixel_y < 4) services.display.write_opacity(static_cast<int>(i), 0.5f);
        }
    };
    transport::integrator_registry().add({"test:silent", "for this test", {}, [](const auto&, auto) {
                                              return raylex::Result<std::unique_ptr<transport::Integrator>>(
                                                  std::make_unique<Silent>());
                                          }});
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    for (const char* name : {"Nn", "P", "id", "albedo", "z", "st", "Vn", "wireframe", "a"})
        settings.channels.list.push_back(aov(name));
    const auto scene = scene_of(room);
    const auto expected = render_of(scene, settings);
    settings.paths.integrator = transport::SceneEntity{};
    settings.paths.integrator->type = "test:silent";
    const auto output = render_of(scene, settings);
    const display::PixelRegion silent{0, 4, 24, 24}, reported{0, 0, 24, 4};
    for (display::ChannelId id = 1; id < 10; ++id) {
        CAPTURE(output.frame_buffer.channels()[static_cast<std::size_t>(id)].name);
        CHECK(output.frame_buffer.resolve(id, silent) == expected.frame_buffer.resolve(id, silent));
    }
    CHECK(output.frame_buffer.resolve_alpha(silent) == expected.frame_buffer.resolve_alpha(silent));
    const std::vector<double> covered = expected.frame_buffer.resolve_alpha(reported),
                              mixed = output.frame_buffer.resolve_alpha(reported);
    for (std::size_t i = 0; i < mixed.size(); ++i)
        if (covered[i] == 1) CHECK(mixed[i] == 0.75);  // half of the samples report 0.5
}
