// Guides in files: renders that share a file have the bits of renders that train, and no other file is taken for one.
#include <cerrno>
#include <chrono>

#include "display/checkpoint/record_file.h"
#include "transport/guide/guide_support.h"

using namespace render_test;

namespace {

transport::RenderSettings shared_guide(const std::string& file, const std::string& mode = "on", int samples = 32) {
    transport::RenderSettings settings = guided_settings(samples, 16);
    settings.paths.integrator = with_guide(integrator_named("path"), mode, samples);
    settings.paths.guide_file = file;
    return settings;
}

/// Checks that the render ends with an Error about this file that has all of `words`, and returns it.
void check_unusable(const transport::SceneDescription& scene, const transport::RenderSettings& settings,
                    const std::vector<std::string>& words) {
    const auto output = transport::render(scene, settings);
    REQUIRE_FALSE(output.ok());
    const std::string text = output.error().to_string();
    CAPTURE(text, settings.paths.guide_file);
    CHECK(output.error().file == settings.paths.guide_file);
    for (const std::string& word : words) {
        CAPTURE(word);
        CHECK(text.find(word) != std::string::npos);
    }
}

}  // namespace

TEST_CASE("a guide in a file gives the bits of the training", "[guide][render][checkpoint][law3]") {
    const auto scene = scene_of(room);
    const std::string mode = GENERATE("on", "auto");
    const ScratchFile file, other;
    const auto trained = render_of(scene, shared_guide("", mode));
    CHECK((trained.statistics.guide.used || mode == "auto"));
    const auto written = render_of(scene, shared_guide(file.path(), mode));
    REQUIRE(file.exists());
    CHECK_FALSE(written.statistics.guide.read);
    CHECK(written.statistics.guide.paths > 0);
    CHECK(written.statistics.pilot_rays > 0);
    const std::string bytes = file.bytes();
    transport::RenderSettings settings = shared_guide(file.path(), mode);
    settings.machine.threads = 3;
    const auto read = render_of(scene, settings);
    CHECK((frame_bits(written) == frame_bits(trained)));
    CHECK((frame_bits(read) == frame_bits(trained)));
    CHECK((file.bytes() == bytes));
    // The training is counted where it was made.
    const transport::GuideSummary &here = read.statistics.guide, &there = written.statistics.guide;
    CHECK(here.read);
    CHECK(read.statistics.pilot_rays == 0);
    CHECK(here.paths == 0);
    CHECK(here.cpu_seconds == 0);
    CHECK(here.samples == there.samples);
    CHECK(here.used == there.used);
    CHECK(here.gain == there.gain);
    // Every writer writes the same bytes, with any number of threads.
    settings.paths.guide_file = other.path();
    render_of(scene, settings);
    CHECK((other.bytes() == bytes));
}

TEST_CASE("shards and crops that read one guide have the bits of the whole render", "[guide][render][law3]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    transport::RenderSettings settings = shared_guide(file.path(), "on", 0);
    settings.samples.per_pixel = 128;
    settings.paths.guide_file.clear();
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.guide.samples == 32);
    settings.paths.guide_file = file.path();
    settings.samples.whole = 128;
    settings.samples.per_pixel = 48;
    auto merged = render_of(scene, settings);
    CHECK_FALSE(merged.statistics.guide.read);
    settings.samples.first = 48;
    settings.samples.per_pixel = 128;
    const auto last = render_of(scene, settings);
    CHECK(last.statistics.guide.read);
    REQUIRE(merged.frame_buffer.merge(last.frame_buffer).ok());
    CHECK((frame_bits(merged) == frame_bits(whole)));
    settings.samples.first = 0;
    settings.film.crop = display::PixelRegion{3, 5, 11, 20};
    const auto crop = render_of(scene, settings);
    CHECK(crop.statistics.guide.read);
    CHECK(crop.frame_buffer.resolve(crop.beauty, *settings.film.crop) ==
          whole.frame_buffer.resolve(whole.beauty, *settings.film.crop));
}

TEST_CASE("a guide file fits each render that would train the same guide", "[guide][render]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    transport::RenderSettings settings = shared_guide(file.path());
    render_of(scene, settings);
    settings.samples.per_pixel = 32;  // guidesamples is set
    settings.channels.list = {lpe_channel("direct", "CDL"), aov("Nn")};
    CHECK(render_of(scene, settings).statistics.guide.read);
    settings.channels.beauty = false;  // the guide now learns from "direct"
    check_unusable(scene, settings, {"another render", "beauty: true there, false here", "channel direct"});
    // A checkpoint has a guide, too, but is no guide file.
    const ScratchFile checkpoint;
    settings = shared_guide("");
    settings.paths.integrator = with_guide(counted("path"), "on", 16);
    settings.samples.per_pixel = 64;
    settings.checkpoint = transport::CheckpointSettings{.file = checkpoint.path(), .seconds = 60};
    std::atomic<bool> stop{false};
    interruption().begin(15'000, &stop);  // within the image's 36,864, whether the training's 9,792 count or not
    REQUIRE(transport::render(scene, settings, {}, &stop).ok());
    interruption().begin(0, nullptr);
    REQUIRE(checkpoint.exists());
    check_unusable(scene, shared_guide(checkpoint.path()), {"another render", "training: nothing there"});
}

TEST_CASE("the guide of another render is refused with the difference", "[guide][render][law7]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    const transport::RenderSettings first = shared_guide(file.path(), "on", 0);
    render_of(scene, first);
    const std::string bytes = file.bytes();
    check_unusable(scene_of(room + "LightSource \"point\"\n"), first,
                   {"another render", "scene: ", "a name that does not exist yet"});
    transport::RenderSettings settings = first;
    settings.samples.seed = 1;
    check_unusable(scene, settings, {"seed: 0 there, 1 here"});
    settings = first;
    settings.samples.per_pixel = 128;
    check_unusable(scene, settings, {"training: 4 samples of each pixel there, 32 samples of each pixel here"});
    settings = first;
    settings.film.resolution = std::array{12, 12};
    check_unusable(scene, settings, {"resolution: 24x24 there, 12x12 here"});
    settings = first;
    settings.paths.max_depth = 3;
    check_unusable(scene, settings, {"max depth: nothing there, 3 here"});
    settings = first;
    settings.paths.integrator->parameters.parameters.push_back(number_parameter("rrthreshold", 0));
    check_unusable(scene, settings, {"integrator: "});
    settings = first;
    settings.paths.guide_samples = 4;
    settings.paths.integrator = path_with(text_parameter("guide", "auto"));
    check_unusable(scene, settings, {"integrator: "});
    settings = first;
    settings.identity = {{"raylex", "another build"}};
    check_unusable(scene, settings, {"raylex: nothing there, another build here"});
    CHECK((file.bytes() == bytes));
}

TEST_CASE("a damaged guide file is refused at every byte", "[guide][render][law7]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    const transport::RenderSettings settings = shared_guide(file.path());
    render_of(scene, settings);
    const std::string bytes = file.bytes();
    for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{31}, std::size_t{100}, bytes.size() / 3,
                                   bytes.size() - 9, bytes.size() - 1}) {
        CAPTURE(size);
        file.write(bytes.substr(0, size));
        check_unusable(scene, settings, {"cannot use this guide file", "a name that does not exist yet"});
    }
    // One flipped bit in the magic number, the version, the identity, the guide and the last checksum.
    for (const std::size_t at :
         {std::size_t{0}, std::size_t{12}, std::size_t{90}, bytes.size() / 2, bytes.size() - 1}) {
        CAPTURE(at);
        std::string flipped = bytes;
        flipped[at] = static_cast<char>(flipped[at] ^ 4);
        file.write(flipped);
        check_unusable(scene, settings, {"cannot use this guide file"});
    }
    file.write(bytes + "x");
    check_unusable(scene, settings, {"cannot use this guide file"});
    // A sound record of the right render whose guide is none.
    file.write(bytes);
    auto record = display::read_record_file(file.path());
    REQUIRE(record.ok());
    record->sections.front().content.pop_back();
    REQUIRE(display::write_record_file(file.path(), *record).ok());
    check_unusable(scene, settings, {"its guide is damaged"});
    record->sections.clear();
    REQUIRE(display::write_record_file(file.path(), *record).ok());
    check_unusable(scene, settings, {"its guide is damaged"});
}

TEST_CASE("a guide file that cannot be read or written ends the render before the training", "[guide][render][law7]") {
    const auto scene = scene_of(room);
    const raylex::test::Folder folder;
    const auto refused = [&](const std::string& file, const std::vector<std::string>& words) {
        transport::RenderSettings settings = shared_guide(file, "on", 4096);  // the training would take long
        const auto begin = std::chrono::steady_clock::now();
        check_unusable(scene, settings, words);
        // 2.4 million paths take longer than half a minute on two threads; the refusal takes milliseconds.
        CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(5));
    };
    refused(folder.path(), {"cannot use this guide file"});
    refused(folder.path("missing/guide"), {"No such file"});
    refused(folder.write("scene.pbrt", room), {"cannot use this guide file"});
    refused("/dev/null", {"cannot use this guide file"});
    transport::RenderSettings off = shared_guide(folder.path("off"), "off");
    check_unusable(scene, off, {"integrator 'path' learns no guide", "auto"});
    off.paths.integrator = integrator_named("lighttracer");
    check_unusable(scene, off, {"integrator 'lighttracer' learns no guide"});
    CHECK(folder.names() == std::vector<std::string>{"scene.pbrt"});
}

TEST_CASE("a guide file records that auto does not train", "[guide][render]") {
    const ScratchFile file;
    for (const bool read : {false, true}) {
        const auto output = render_of(scene_of(room), shared_guide(file.path(), "auto", 0));
        CHECK(output.statistics.guide.samples == 0);
        CHECK(output.statistics.guide.read == read);
        CHECK(file.exists());
    }
}

TEST_CASE("a training that was cut leaves no guide file", "[guide][render]") {
    const auto scene = scene_of(room);
    const raylex::test::Folder folder;
    transport::RenderSettings settings = shared_guide(folder.path("guide"), "on", 4096);
    std::atomic<bool> stop{true};
    CHECK(transport::render(scene, settings, {}, &stop).ok());
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.seconds = 0.4};
    const auto limited = transport::render(scene, settings);
    REQUIRE(limited.ok());
    CHECK(limited->statistics.guide.cut);
    settings = shared_guide(folder.path("guide"));
    settings.samples.only = transport::SampleChoice{1, 1, 1};  // a replay writes no file
    CHECK(transport::render(scene, settings).ok());
    CHECK(folder.names().empty());
}

TEST_CASE("a resumed render writes the guide of its checkpoint, but not that of another render",
          "[guide][render][checkpoint]") {
    const auto scene = scene_of(room);
    const ScratchFile checkpoint, whole, late, other;
    transport::RenderSettings settings = shared_guide(whole.path());
    settings.paths.integrator = with_guide(counted("path"), "on", 16);
    settings.samples.per_pixel = 64;
    const auto uninterrupted = render_of(scene, settings);
    settings.paths.guide_file.clear();
    settings.checkpoint = transport::CheckpointSettings{.file = checkpoint.path(), .seconds = 60};
    std::atomic<bool> stop{false};
    interruption().begin(15'000, &stop);  // within the image's 36,864, whether the training's 9,792 count or not
    REQUIRE(transport::render(scene, settings, {}, &stop).ok());
    interruption().begin(0, nullptr);
    settings.checkpoint->resume = true;
    settings.paths.guide_file = other.path();
    settings.samples.seed = 1;
    CHECK_FALSE(transport::render(scene, settings).ok());
    CHECK_FALSE(other.exists());
    settings.samples.seed = 0;
    settings.paths.guide_file = late.path();
    const auto resumed = render_of(scene, settings);
    CHECK(resumed.samples.resumed > 0);
    CHECK((frame_bits(resumed) == frame_bits(uninterrupted)));
    CHECK((late.bytes() == whole.bytes()));
}

TEST_CASE("a guide that cannot be written after its training is a warning", "[guide][render][law7]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    const auto trained = render_of(scene, shared_guide(""));
    display::set_file_fault(
        [](display::FileCall call, const std::string&) { return call == display::FileCall::write ? ENOSPC : 0; });
    const auto output = transport::render(scene, shared_guide(file.path()));
    display::set_file_fault(nullptr);
    REQUIRE(output.ok());
    REQUIRE_FALSE(output->warnings.empty());
    CHECK(output->warnings.back().file == file.path());
    CHECK_FALSE(file.exists());
    CHECK((frame_bits(*output) == frame_bits(trained)));
}
