#include "display/drivers/driver_set.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <limits>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/drivers/packet_sender.h"
#include "display/drivers/tev_driver.h"
#include "display/output/reader/exr_reader.h"
#include "files.h"
#include "tev_receiver.h"

using namespace raylex::display;
using raylex::ParameterType;
using raylex::test::Folder;
using raylex::test::TevReceiver;

namespace {

constexpr int driver_width = 300, driver_height = 120;  // two slices per layer
constexpr float inf = std::numeric_limits<float>::infinity();

std::vector<ChannelDefinition> driver_channels() {
    std::vector<ChannelDefinition> list(3);
    list[0].name = "beauty";
    list[0].style = list[1].style = ChannelStyle::expression;
    list[1].name = "diffuse";
    list[2].name = "z";
    list[2].type = ChannelType::real;
    list[2].rule = FilterRule::zmin;
    list[2].miss_value = inf;
    return list;
}

FrameBuffer filled_for_drivers() {
    const auto list = driver_channels();
    FrameBuffer buffer({driver_width, driver_height}, list);
    SampleTable table(list, 1);
    for (int pixel = 0; pixel < driver_width * driver_height; ++pixel) {
        CameraRow row;
        row.pixel_x = pixel % driver_width;
        row.pixel_y = pixel / driver_width;
        table.begin(std::span(&row, 1));
        for (int c = 0; c < 3; ++c) {
            table.raw_values(0)[c] = pixel + 0.25 * c;
            table.raw_values(1)[c] = 0.5 * pixel;
        }
        table.touch(0);
        table.touch(1);
        table.opacity[0] = raylex::RgbD(pixel % 2 == 0 ? 1.0 : 0.0);
        if (pixel % 3 != 0) {
            table.touch(2);
            table.raw_values(2)[0] = 7 + pixel;
            table.set_row_state(2, 0, SampleTable::RowState::written);
        }
        buffer.accumulate(table);
    }
    return buffer;
}

DriverImage driver_image_of(const std::vector<ChannelDefinition>& list) {
    DriverImage image;
    image.title = "out.exr";
    image.width = driver_width;
    image.height = driver_height;
    image.layers = driver_layers(list, 0);
    image.channels = list;
    image.beauty = 0;
    return image;
}

PixelSource source_of(const FrameBuffer& buffer) {
    return {[&](ChannelId id, const PixelRegion& region) { return buffer.resolve(id, region); },
            [&](const PixelRegion& region) { return buffer.resolve_alpha(region); }};
}

std::unique_ptr<DisplayDriver> driver(const std::string& text) {
    auto request = parse_driver_request(text, {"--driver", 0, 0});
    if (!request) FAIL(request.error().message);
    auto made = make_display_driver(request->name, request->parameters, {});
    if (!made) FAIL(made.error().message);
    return std::move(*made);
}

double seconds_of(const std::function<void()>& action) {
    const auto begin = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

template <class Condition>
bool eventually(Condition condition) {
    for (int i = 0; i < 500; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

}  // namespace

TEST_CASE("a viewer receives every layer, during and after rendering", "[display][tev]") {
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    TevReceiver viewer;
    DriverSet drivers;
    drivers.add(driver("tev:host=127.0.0.1,port=" + std::to_string(viewer.port())));
    REQUIRE(drivers.open(driver_image_of(list)).ok());
    drivers.update(1000, 0.5, source_of(buffer));  // a long render: enough time for all slices
    CHECK(eventually([&] { return viewer.images()["out.exr"].updates > 0; }));
    REQUIRE(drivers.close({buffer, 0, {}}).ok());
    CHECK(drivers.take_warnings() == std::vector<std::string>());

    const std::vector<double> beauty = buffer.resolve(0), diffuse = buffer.resolve(1), z = buffer.resolve(2),
                              alpha = buffer.resolve_alpha();
    raylex::test::ViewedImage seen;
    CHECK(eventually([&] {
        seen = viewer.images()["out.exr"];
        return seen.channels["Z"].back() == static_cast<float>(z.back());
    }));
    CHECK(viewer.complaint().empty());
    CHECK(seen.width == driver_width);
    CHECK(seen.height == driver_height);
    CHECK(seen.order == std::vector<std::string>{"R", "G", "B", "A", "diffuse.R", "diffuse.G", "diffuse.B", "Z"});
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < driver_width * driver_height; ++i) {
        wrong += seen.channels["R"][i] != static_cast<float>(beauty[3 * i]);
        wrong += seen.channels["B"][i] != static_cast<float>(beauty[3 * i + 2]);
        wrong += seen.channels["A"][i] != static_cast<float>(alpha[i]);
        wrong += seen.channels["diffuse.G"][i] != static_cast<float>(diffuse[3 * i + 1]);
        wrong += seen.channels["Z"][i] != static_cast<float>(z[i]);
    }
    CHECK(wrong == 0);
}

TEST_CASE("a live view uses at most its share of the time", "[display][tev]") {
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    TevReceiver viewer;
    DriverSet drivers;
    drivers.add(driver("tev:host=127.0.0.1,port=" + std::to_string(viewer.port())));
    REQUIRE(drivers.open(driver_image_of(list)).ok());
    int resolved = 0;
    PixelSource counting = source_of(buffer);
    counting.resolve = [&](ChannelId id, const PixelRegion& region) {
        ++resolved;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return buffer.resolve(id, region);
    };
    drivers.update(0, 0, counting);
    CHECK(resolved == 0);
    drivers.update(1.0, 0.1, counting);  // 20 ms of a second: one slice of at least 20 ms
    CHECK(resolved == 1);
    drivers.update(1.01, 0.1, counting);
    CHECK(resolved == 1);
}

TEST_CASE("a missing viewer costs a render only one warning", "[display][tev]") {
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    int port;
    {
        const TevReceiver gone;
        port = gone.port();
    }
    DriverSet drivers;
    drivers.add(driver("tev:host=127.0.0.1,port=" + std::to_string(port)));
    std::vector<std::string> warnings;
    // The loopback refuses at once. The bound allows for a busy machine.
    CHECK(seconds_of([&] {
              REQUIRE(drivers.open(driver_image_of(list)).ok());
              CHECK(eventually([&] {
                  for (const std::string& each : drivers.take_warnings()) warnings.push_back(each);
                  return !warnings.empty();
              }));
              drivers.update(1000, 0.5, source_of(buffer));
              REQUIRE(drivers.close({buffer, 0, {}}).ok());
          }) < 2);
    for (const std::string& each : drivers.take_warnings()) warnings.push_back(each);
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].find("127.0.0.1:" + std::to_string(port)) != std::string::npos);
    CHECK(warnings[0].find("Connection refused") != std::string::npos);
}

TEST_CASE("a viewer that leaves and one that does not read each give one warning", "[display][tev][gate]") {
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    const bool leaves = GENERATE(true, false);
    TevReceiver viewer(leaves ? TevReceiver::Manner::leaves : TevReceiver::Manner::never_reads);
    DriverSet drivers;
    drivers.add(driver("tev:host=127.0.0.1,port=" + std::to_string(viewer.port())));
    REQUIRE(drivers.open(driver_image_of(list)).ok());
    std::vector<std::string> warnings;
    const auto take = [&] {
        for (const std::string& each : drivers.take_warnings()) warnings.push_back(each);
    };
    for (int i = 0; i < 100; ++i) {
        // No call waits for the viewer: the bound is 2 % of 10 s, plus a slice, plus the load of a busy machine.
        CHECK(seconds_of([&] { drivers.update(10, 0.01 * i, source_of(buffer)); }) < 1.5);
        take();
    }
    CHECK(seconds_of([&] {
              REQUIRE(drivers.close({buffer, 0, {}}).ok());
          }) < DriverSet::patience_seconds + 3);  // plus the second for draining
    take();
    if (leaves) CHECK(warnings.size() == 1);
    else CHECK(warnings.size() <= 1);  // the system's buffers may have taken everything
}

TEST_CASE("a viewer that does not read takes nothing from another one", "[display][tev][gate]") {
    // More than the queue of a viewer and the buffers of the system hold.
    const int side = 1024;
    const std::vector<ChannelDefinition> list = driver_channels();
    const FrameBuffer buffer({side, side}, list);
    DriverImage image = driver_image_of(list);
    image.width = image.height = side;
    TevReceiver stuck(TevReceiver::Manner::never_reads), reader;
    DriverSet drivers;
    for (const int port : {stuck.port(), reader.port()})
        drivers.add(driver("tev:host=127.0.0.1,port=" + std::to_string(port)));
    REQUIRE(drivers.open(image).ok());
    REQUIRE(drivers.close({buffer, 0, {}}).ok());
    const std::vector<std::string> warnings = drivers.take_warnings();
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].find(std::to_string(stuck.port())) != std::string::npos);
    const int slices = side / std::max(1, DriverSet::slice_pixels / side);
    CHECK(eventually(
        [&] { return reader.images()["out.exr"].updates == slices * static_cast<int>(image.layers.size()); }));
}

TEST_CASE("the bytes in a queue are limited, but one packet always fits", "[display][tev]") {
    TevReceiver viewer(TevReceiver::Manner::never_reads);
    PacketSender sender("127.0.0.1", viewer.port(), 1000);
    REQUIRE(sender.send(std::vector<unsigned char>(8u << 20)));  // more than the system's buffers hold
    CHECK(!sender.send(std::vector<unsigned char>(1)));
    CHECK(!sender.drain(0.05, 10));
    CHECK(sender.failure().empty());
}

TEST_CASE("several drivers get the same image, each in its own form", "[display][drivers]") {
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    const Folder folder;
    DriverSet drivers;
    drivers.add(driver("exr:file='" + folder.path("a,b.exr") + "'"));
    drivers.add(driver("exr:file=" + folder.path("c.exr")));
    REQUIRE(drivers.open(driver_image_of(list)).ok());
    CHECK(folder.names().size() == 0);
    REQUIRE(drivers.close({buffer, 0, {}}).ok());
    CHECK(drivers.files() == std::vector<std::string>{folder.path("a,b.exr"), folder.path("c.exr")});
    for (const std::string& file : drivers.files()) {
        const auto image = read_exr(file);
        REQUIRE(image.ok());
        CHECK(image->layer("diffuse")->triple()[1]->values[8] == 4);
    }
}

TEST_CASE("drivers refuse before the render what they cannot do after it", "[display][drivers][law7]") {
    const auto list = driver_channels();
    const auto opened = [&](const std::string& text) {
        DriverSet drivers;
        drivers.add(driver(text));
        const auto status = drivers.open(driver_image_of(list));
        return status.ok() ? std::string() : status.error().message;
    };
    CHECK(opened("exr:file=/nowhere/at/all.exr").find("No such file or directory") != std::string::npos);
    const auto refused = [](const std::string& text) {
        auto request = parse_driver_request(text, {"--driver", 0, 0});
        if (!request) return request.error().message + " " + request.error().hint;
        auto made = make_display_driver(request->name, request->parameters, {});
        return made.ok() ? std::string() : made.error().message + " " + made.error().hint;
    };
    CHECK(refused("exrr:file=a.exr").find("did you mean 'exr'") != std::string::npos);
    CHECK(refused("exr:fil=a.exr").find("has no file") != std::string::npos);
    CHECK(refused("exr:file=a.exr,flie=b").find("did you mean 'file'") != std::string::npos);
    CHECK(refused("exr:a.exr").find("expected KEY=VALUE") != std::string::npos);
    CHECK(refused("tev:port=http").find("expected a number") != std::string::npos);
    CHECK(refused("tev:port=1.5").find("expected a whole number") != std::string::npos);
    CHECK(refused("tev:port=70000").find("from 1 to 65535") != std::string::npos);
}

TEST_CASE("addresses of viewers are parsed in all usual forms", "[display][tev][law7]") {
    const auto read = [](const std::string& text) {
        const auto set = tev_address(text, {"--tev", 0, 0});
        if (!set) return std::string("refused");
        return *set->string_or("host", "-") + " " + std::to_string(*set->integer_or("port", -1));
    };
    CHECK(read("viewer.example:1234") == "viewer.example 1234");
    CHECK(read("viewer") == "viewer -1");
    CHECK(read(":1234") == "- 1234");
    CHECK(read("[::1]:1234") == "::1 1234");
    for (const char* wrong : {"", "a:b", "a:0", "a:65536", "a:1:2", "a b:1", "[::1:5"}) {
        CAPTURE(wrong);
        CHECK(read(wrong) == "refused");
    }
}

TEST_CASE("a registered driver is found by its name", "[display][drivers]") {
    struct Counter : DisplayDriver {
        raylex::Status open(const DriverImage& image) override {
            return layers = image.layers.size(), raylex::success();
        }
        [[nodiscard]] bool is_live() const override { return true; }
        bool region(const DriverRegion& r) override { return pixels += r.values.size(), true; }
        void progress(double fraction) override { last = fraction; }
        raylex::Status close(const FinishedImage&) override { return raylex::success(); }
        std::size_t layers = 0, pixels = 0;
        double last = 0;
    };
    static Counter* made = nullptr;
    display_driver_registry().add(
        {"counter",
         "counts",
         {{"step", ParameterType::real, "1", "of what"}},
         [](const raylex::ParameterSet& set, const DriverContext&) -> raylex::Result<std::unique_ptr<DisplayDriver>> {
             auto step = set.real_or("step", 1);
             if (!step) return step.error();
             auto counter = std::make_unique<Counter>();
             made = counter.get();
             return std::unique_ptr<DisplayDriver>(std::move(counter));
         }});
    const FrameBuffer buffer = filled_for_drivers();
    const auto list = driver_channels();
    DriverSet drivers;
    drivers.add(driver("counter:step=0.5"));
    REQUIRE(drivers.open(driver_image_of(list)).ok());
    drivers.update(0, 0.75, source_of(buffer));
    CHECK(made->last == 0.75);
    CHECK(made->pixels == 0);
    REQUIRE(drivers.close({buffer, 0, {}}).ok());
    CHECK(made->layers == 3);
    CHECK(made->pixels == driver_width * driver_height * (4 + 3 + 1));
}
