// The stages of a render follow from one another, and budgets become schedules.
#include <array>
#include <chrono>
#include <type_traits>

#include "tests/transport/render_support.h"
#include "transport/render/loop/render_loop.h"
#include "transport/render/schedules/adaptive_schedule.h"
#include "transport/render/schedules/limited_schedule.h"
#include "transport/render/schedules/replay_schedule.h"
#include "transport/render/schedules/synchronous_schedule.h"

using namespace render_test;

static_assert(!std::is_default_constructible_v<transport::ResolvedJob>);
static_assert(
    !std::is_constructible_v<transport::ResolvedJob, const transport::BuiltScene&, const transport::RenderSettings&>);
static_assert(!std::is_constructible_v<transport::PreparedJob, transport::ResolvedJob>);
static_assert(!std::is_constructible_v<transport::RenderTarget, display::FrameBuffer>);
static_assert(!std::is_default_constructible_v<transport::FinishedLoop>);

namespace {

/// Calls look(schedule) with the schedule of `settings` for the room, 24 x 24 pixels: 4 tiles.
template <class Look>
void with_schedule(const transport::RenderSettings& settings, const Look& look) {
    const auto scene = transport::BuiltScene::build(scene_of(room));
    REQUIRE(scene.ok());
    auto job = transport::ResolvedJob::resolve(**scene, settings);
    REQUIRE(job.ok());
    const auto prepared = transport::PreparedJob::prepare(*std::move(job));
    REQUIRE(prepared.ok());
    const auto target = transport::RenderTarget::allocate(*prepared, {});
    REQUIRE(target.ok());
    look(*transport::make_schedule(*prepared, *target));
}

/// The tasks of the phases from `position` on; ends of phases change only the position.
std::vector<std::array<std::uint64_t, 2>> phases_of(transport::Schedule& schedule) {
    std::vector<std::array<std::uint64_t, 2>> phases;
    transport::RenderPosition position = schedule.beginning();
    for (; !schedule.finished(position); ++position.phase, position.task = 0) {
        const std::uint64_t end = schedule.begin_phase(position);
        phases.push_back({position.task, end});
    }
    return phases;
}

}  // namespace

TEST_CASE("each budget becomes its own kind of schedule", "[render][schedule]") {
    using Phases = std::vector<std::array<std::uint64_t, 2>>;
    transport::RenderSettings settings;
    settings.samples.per_pixel = 40;  // three blocks
    with_schedule(settings, [](transport::Schedule& plain) {
        CHECK(phases_of(plain) == Phases{{0, 12}});
        CHECK(plain.can_save_amid_phase());
    });
    settings.samples.first = 16;
    with_schedule(settings, [](transport::Schedule& shard) { CHECK(phases_of(shard) == Phases{{4, 12}}); });
    settings.samples.first = 0;
    settings.paths.integrator = transport::SceneEntity{};
    settings.paths.integrator->type = "pssmlt";
    with_schedule(settings, [](transport::Schedule& synchronous) {
        CHECK(dynamic_cast<transport::SynchronousSchedule*>(&synchronous) != nullptr);
        CHECK(phases_of(synchronous) == Phases{{0, 4}, {4, 8}, {8, 12}});
        CHECK_FALSE(synchronous.can_save_amid_phase());
    });
    settings.paths.integrator.reset();
    settings.stop.limit = transport::SampleLimit{.error = 0.1};
    with_schedule(settings, [](transport::Schedule& limited) {
        CHECK(dynamic_cast<transport::LimitedSchedule*>(&limited) != nullptr);
        CHECK(limited.error() != nullptr);
    });
    settings.stop.limit.reset();
    settings.stop.adaptive = display::AdaptiveSettings{};
    with_schedule(settings, [](transport::Schedule& adaptive) {
        CHECK(adaptive.section() == "adaptive");
        transport::RenderPosition position = adaptive.beginning();
        CHECK(adaptive.begin_phase(position) == 4);  // every tile has open pixels
    });
    settings.samples.only = transport::SampleChoice{.x = 3, .y = 4, .sample = 5};
    with_schedule(settings, [](transport::Schedule& replay) {
        CHECK(dynamic_cast<transport::ReplaySchedule*>(&replay) != nullptr);
        CHECK(phases_of(replay) == Phases{{0, 1}});
        CHECK(replay.error() == nullptr);
    });
}

TEST_CASE("thousands of labels and materials need no table of all pairs", "[release-only]") {
    std::string text =
        "Film \"rgb\" \"integer xresolution\" 2 \"integer yresolution\" 2\nWorldBegin\n"
        "LightSource \"infinite\"\n";
    for (int i = 0; i < 20'000; ++i) {
        const std::string name = "\"m" + std::to_string(i) + "\"";
        text +=
            "MakeNamedMaterial " + name + " \"string type\" \"diffuse\"\nNamedMaterial " + name + " Shape \"sphere\"\n";
    }
    const auto scene = scene_of(text);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1;
    settings.channels.list = {lpe_channel("direct", "CDL")};
    const auto begin = std::chrono::steady_clock::now();
    render_of(scene, settings);
    // 1 s; all pairs took 20 s and 1.6 GB.
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < 8);
}
