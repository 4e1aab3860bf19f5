// raylex denoise and raylex render --denoise, on renders and on images of other renderers.
#include <catch2/catch.hpp>

#include <ImfMultiPartInputFile.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "../display/files.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_edit.h"
#include "support.h"

namespace raylex::test {
namespace {

const std::string split_options = " --lpe diffuse='C<RD>[<L.>O]' --light-groups --aov z --cryptomatte object ";

/// A foreign layer of one colour with noise of this deviation.
std::vector<ForeignChannel> noisy_channels(const std::string& prefix, unsigned seed, float mean, float deviation) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(mean, std::max(deviation, 1e-6f));
    std::vector<ForeignChannel> channels;
    for (const char* plane : {"R", "G", "B"}) {
        std::vector<float> values(40 * 30);
        for (float& value : values) value = deviation > 0 ? normal(random) : mean;
        channels.push_back({prefix + plane, Imf::HALF, values});
    }
    return channels;
}

double scatter(const display::ExrImage& image, const std::string& layer, float mean) {
    double sum = 0;
    for (const char* name : {"R", "G", "B"})
        for (const float value : plane(image, layer, name)) sum += std::pow(static_cast<double>(value - mean), 2);
    return sum / (3.0 * image.width * image.height);
}

}  // namespace

TEST_CASE("a denoised render sums in every partition, and keeps everything else", "[cli][denoise][law1]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const std::string render = "render scene.pbrt --spp 8" + split_options;
    REQUIRE(run_raylex(folder, render + "-o plain.exr").code == 0);
    const Outcome outcome = run_raylex(folder, render + "-o denoised.exr --denoise --keep-noisy");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "root mean squared error, estimated"));
    const Outcome verified = run_raylex(folder, "verify denoised.exr");
    CHECK(verified.code == 0);
    CHECK(contains(verified.out, "'auto'"));
    CHECK(contains(verified.out, "'light_groups'"));
    const auto plain = display::read_exr(folder.path("plain.exr")),
               image = display::read_exr(folder.path("denoised.exr"));
    REQUIRE(plain);
    REQUIRE(image);
    CHECK(image->attributes.at("raylex/denoised").starts_with("raylex denoise: "));
    CHECK(image->attributes.at("error/diffuse").starts_with("mean squared error "));
    CHECK(image->attributes.at("verdict/auto").starts_with("holds"));
    CHECK(image->attributes.at("lpe/diffuse") == plain->attributes.at("lpe/diffuse"));
    CHECK(plane(*image, "", "A") == plane(*plain, "", "A"));
    CHECK(plane(*image, "z", "Z") == plane(*plain, "z", "Z"));
    CHECK(plane(*image, "CryptoObject00", "R") == plane(*plain, "CryptoObject00", "R"));
    CHECK(plane(*image, "beauty_noisy", "R") == plane(*plain, "", "R"));
    CHECK(plane(*image, "diffuse_noisy", "G") == plane(*plain, "diffuse", "G"));
    CHECK(plane(*image, "", "R") != plane(*plain, "", "R"));
    REQUIRE(image->layer("diffuse_error") != nullptr);
    CHECK(image->layer("diffuse_mse") != nullptr);
    check_refused(folder, "denoise denoised.exr -o again.exr", {"denoised already"});

    // The command gives the same bits as the render, and leaves the statistics out.
    REQUIRE(run_raylex(folder, render + "-o noisy.exr --aov albedo,Nn --statistics beauty=mse --statistics albedo=mse "
                                        "--statistics Nn=mse --statistics diffuse=mse --statistics rest=mse "
                                        "--statistics light_default=mse")
                .code == 0);
    const Outcome command = run_raylex(folder, "denoise noisy.exr -o command.exr --threads 3");
    CAPTURE(command.err);
    REQUIRE(command.code == 0);
    const auto other = display::read_exr(folder.path("command.exr"));
    REQUIRE(other);
    for (const char* layer : {"", "diffuse", "rest"}) CHECK(plane(*other, layer, "G") == plane(*image, layer, "G"));
    CHECK(other->layer("diffuse_mse") == nullptr);
    CHECK(other->layer("diffuse_noisy") == nullptr);
    CHECK_FALSE(other->attributes.contains("statistics/diffuse_mse"));
}

TEST_CASE("a layer whose noise is unknown is refused, with what is needed", "[cli][denoise][law7]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    REQUIRE(run_raylex(folder, "render scene.pbrt -o plain.exr --spp 4").code == 0);
    check_refused(folder, "denoise plain.exr -o out.exr",
                  {"plain.exr", "no layer of light has statistics", "--second", "raylex render --denoise"});
    REQUIRE(run_raylex(folder, "render scene.pbrt -o part.exr --spp 4 --lpe d='C<RD>L' --statistics beauty=mse").code ==
            0);
    check_refused(folder, "denoise part.exr -o out.exr", {"the layer 'd' of partition 'auto'", "--statistics d=mse"});
    check_refused(folder, "denoise part.exr -o part.exr", {"would be overwritten"});
    check_refused(folder, "denoise part.exr -o out.png", {"does not end in .exr"});
    check_refused(folder, "denoise missing.exr -o out.exr", {"missing.exr"});
    CHECK_FALSE(folder.has("out.exr"));
}

TEST_CASE("images of other renderers are denoised with variances, halves or a second render", "[cli][denoise]") {
    const Folder folder;
    const auto join = [](std::vector<ForeignChannel> a, const std::vector<ForeignChannel>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    const auto first = noisy_channels("", 1, 1, 0.2f), second = noisy_channels("", 2, 1, 0.2f);
    write_foreign(folder.path("first.exr"), first, 40, 30);
    write_foreign(folder.path("second.exr"), second, 40, 30);
    REQUIRE(run_raylex(folder, "denoise first.exr --second second.exr -o pair.exr").code == 0);
    CHECK(scatter(*display::read_exr(folder.path("pair.exr")), "", 1) < 0.004);  // 0.02 before

    std::vector<ForeignChannel> variance = noisy_channels("beauty_mse.", 3, 0.04f, 0);
    write_foreign(folder.path("variance.exr"), join(first, variance), 40, 30);
    REQUIRE(run_raylex(folder, "denoise variance.exr -o of_variance.exr").code == 0);
    const auto image = display::read_exr(folder.path("of_variance.exr"));
    REQUIRE(image);
    CHECK(scatter(*image, "", 1) < 0.008);  // 0.04 before
    CHECK(image->layer("")->planes[0].stored == display::StoredType::single_float);
    CHECK(image->layer("beauty_error") != nullptr);

    write_foreign(folder.path("small.exr"), {{"R", Imf::HALF, {1}}, {"G", Imf::HALF, {1}}, {"B", Imf::HALF, {1}}}, 1,
                  1);
    check_refused(folder, "denoise first.exr --second small.exr -o out.exr", {"small.exr", "another size"});
    write_foreign(folder.path("shifted.exr"), second, box(40, 30), {Imath::V2i(1, 0), Imath::V2i(40, 29)});
    check_refused(folder, "denoise first.exr --second shifted.exr -o out.exr", {"another size or data window"});
    write_foreign(folder.path("grey.exr"), {{"Y", Imf::HALF, std::vector<float>(40 * 30, 1)}}, 40, 30);
    check_refused(folder, "denoise first.exr --second grey.exr -o out.exr", {"no layer of light has statistics"});
    check_refused(folder, "denoise first.exr --second first.exr -o out.exr", {"is 0 everywhere"});
    folder.write("black.pbrt", "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\nWorldBegin\n");
    CHECK(run_raylex(folder, "render black.pbrt --denoise -o black.exr --spp 2").code == 0);  // it has no noise
    const auto twice = noisy_channels("beauty.", 4, 1, 0.2f);
    write_foreign(folder.path("twice.exr"), join(first, twice), 40, 30);
    write_foreign(folder.path("twice2.exr"), join(second, twice), 40, 30);
    check_refused(folder, "denoise twice.exr --second twice2.exr -o out.exr", {"two layers are called 'beauty'"});
    // A row has no neighbours to bound its variance by.
    write_foreign(folder.path("row.exr"), join(first, variance), 1200, 1);
    REQUIRE(run_raylex(folder, "denoise row.exr -o denoised_row.exr").code == 0);
    CHECK(scatter(*display::read_exr(folder.path("denoised_row.exr")), "", 1) < 0.02);  // 0.04 before
}

TEST_CASE("a crop is denoised inside its data window, and what lies outside the image keeps its noise",
          "[cli][denoise][law1]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const std::string render = "render scene.pbrt --spp 8 --light-groups --denoise --keep-noisy -o ";
    REQUIRE(run_raylex(folder, render + "crop.exr --crop 2,3,12,14").code == 0);
    CHECK(run_raylex(folder, "verify crop.exr").code == 0);
    const auto image = display::read_exr(folder.path("crop.exr"));
    REQUIRE(image);
    REQUIRE(image->data_window);
    CHECK(image->data_window->y1 == 14);
    const auto denoised = plane(*image, "", "G"), noisy = plane(*image, "beauty_noisy", "G"),
               error = plane(*image, "beauty_error", "beauty_error");
    std::size_t changed = 0;
    for (int y = 0, i = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x, ++i) {
            const auto p = static_cast<std::size_t>(i);
            const bool inside = x >= 2 && x < 12 && y >= 3 && y < 14;
            changed += denoised[p] != noisy[p] ? 1 : 0;
            if (!inside) CHECK((denoised[p] == 0 && error[p] == 0));
        }
    CHECK(changed > 50);

    std::vector<ForeignChannel> channels = noisy_channels("", 1, 1, 0.2f);
    for (const ForeignChannel& each : noisy_channels("beauty_mse.", 3, 0.04f, 0)) channels.push_back(each);
    write_foreign(folder.path("overscan.exr"), channels, {Imath::V2i(4, 3), Imath::V2i(35, 26)}, box(40, 30));
    const Outcome outcome = run_raylex(folder, "denoise overscan.exr -o out.exr");
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "outside the display window (overscan) are not denoised"));
    CHECK(scatter(*display::read_exr(folder.path("out.exr")), "", 1) < 0.008);  // 0.04 before
}

TEST_CASE("layers with dots, chromaticities, and the attributes of a part that is left out are kept",
          "[cli][denoise]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    REQUIRE(run_raylex(folder,
                       "render scene.pbrt --spp 8 --lpe View.Diff='C<RD>L' --rendering-space ACEScg --denoise "
                       "--keep-noisy -o out.exr")
                .code == 0);
    const auto image = display::read_exr(folder.path("out.exr"));
    REQUIRE(image);
    REQUIRE(image->layer("View.Diff_error") != nullptr);
    CHECK(image->layer("View.Diff_error")->planes.size() == 1);
    CHECK(image->layer("View.Diff_noisy")->is_color());
    Imf::MultiPartInputFile file(folder.path("out.exr").c_str());
    for (int i = 0; i < file.parts(); ++i)
        if (std::string(file.header(i).name()).ends_with("_noisy")) {
            REQUIRE(Imf::hasChromaticities(file.header(i)));
            CHECK(Imf::chromaticities(file.header(i)).red == Imf::chromaticities(file.header(0)).red);
        }
    // The statistics are the first part, which has the comments of the file, and the copy lacks it.
    const std::vector<float> variance(40 * 30, 0.04f);
    const std::vector<ForeignChannel> light = noisy_channels("", 1, 1, 0.2f);
    write_foreign_parts(folder.path("plain.exr"),
                        {{"beauty_mse",
                          {{"beauty_mse.R", Imf::FLOAT, variance},
                           {"beauty_mse.G", Imf::FLOAT, variance},
                           {"beauty_mse.B", Imf::FLOAT, variance}}},
                         {"beauty",
                          {{"beauty.R", Imf::FLOAT, light[0].values},
                           {"beauty.G", Imf::FLOAT, light[1].values},
                           {"beauty.B", Imf::FLOAT, light[2].values}}}},
                        40, 30);
    display::ExrEdit comments;
    comments.attributes["comments"] = "of the first part";
    REQUIRE(display::edit_exr(folder.path("plain.exr"), folder.path("parts.exr"), comments));
    const Outcome outcome = run_raylex(folder, "denoise parts.exr -o first.exr");
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    const auto after = display::read_exr(folder.path("first.exr"));
    REQUIRE(after);
    CHECK(after->layer("beauty_mse") == nullptr);
    CHECK(after->attributes.at("comments") == "of the first part");
}

TEST_CASE("denoising refuses renders whose layers would no longer sum or whose noise is unknown",
          "[cli][denoise][law1]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const std::string render = "render scene.pbrt --spp 4 --light-groups -o out.exr --denoise ";
    check_refused(folder, render + "--exr light=half", {"--denoise", "expected no half"});
    check_refused(folder, render + "--display-filter grade:exposure=3", {"--denoise", "expected no display filter"});
    CHECK_FALSE(folder.has("out.exr"));
    REQUIRE(run_raylex(folder,
                       "render scene.pbrt --spp 4 --light-groups --statistics beauty=mse "
                       "--statistics light_default=mse --exr light=half -o half.exr")
                .code == 0);
    check_refused(folder, "denoise half.exr -o out.exr", {"half.exr", "stored as half or with loss"});
}

TEST_CASE("denoising refuses layers that do not sum, names that are taken and values that are no light",
          "[cli][denoise][law1][law7]") {
    const Folder folder;
    const auto half = noisy_channels("a.", 1, 1, 0.2f);
    std::vector<ForeignChannel> channels = half;
    for (const ForeignChannel& each : half) {
        channels.push_back({"b" + each.name.substr(1), Imf::FLOAT, each.values});
        channels.push_back({each.name.substr(2), Imf::FLOAT, each.values});
        for (const std::string name : {"a", "b", "beauty"})
            channels.push_back({name + "_mse." + each.name.substr(2), Imf::FLOAT, std::vector<float>(1200, 0.04f)});
    }
    for (std::size_t c = 0; c < 3; ++c) channels[c].type = Imf::FLOAT;
    display::ExrEdit partition;
    partition.attributes["partition/p"] = "beauty = a + b";
    const auto write = [&](const std::string& name) {
        write_foreign(folder.path("plain.exr"), channels, 40, 30);
        REQUIRE(display::edit_exr(folder.path("plain.exr"), folder.path(name), partition));
    };
    write("missing.exr");  // the beauty is only a
    check_refused(folder, "denoise missing.exr -o out.exr",
                  {"missing.exr", "partition 'p' do not sum to 'beauty'", "raylex verify shows where"});
    for (std::size_t i = 3; i < channels.size(); ++i)
        if (channels[i].name.size() == 1)
            for (float& value : channels[i].values) value *= 2;
    write("sums.exr");
    CHECK(run_raylex(folder, "denoise sums.exr -o out.exr").code == 0);
    check_refused(folder, "denoise sums.exr --second missing.exr -o out2.exr", {"missing.exr", "do not sum"});
    channels.push_back({"a_noisy.R", Imf::FLOAT, half[0].values});
    write("noisy.exr");
    CHECK(run_raylex(folder, "denoise noisy.exr -o out.exr").code == 0);
    check_refused(folder, "denoise noisy.exr -o out2.exr --keep-noisy", {"the layer 'a_noisy' exists"});
    channels.pop_back();
    channels[0].values[7] = std::numeric_limits<float>::quiet_NaN();
    write("nan.exr");
    check_refused(folder, "denoise nan.exr -o out2.exr", {"the layer 'a' has values", "not finite"});
    check_refused(folder, "denoise sums.exr --second nan.exr -o out2.exr", {"sums.exr", "or in nan.exr"});
    folder.write("scene.pbrt", small_scene());
    check_refused(folder, "render scene.pbrt -o out2.exr --keep-noisy", {"--keep-noisy", "expected --denoise"});
    CHECK_FALSE(folder.has("out2.exr"));
}

TEST_CASE("guides with negative variances or enormous values do not change light for the worse",
          "[cli][denoise][law6]") {
    const Folder folder;
    const auto light = noisy_channels("", 1, 1, 0.2f), variance = noisy_channels("beauty_mse.", 3, 0.04f, 0);
    const auto denoised = [&](float size, float noise) {
        std::vector<ForeignChannel> channels = light;
        channels.insert(channels.end(), variance.begin(), variance.end());
        for (const ForeignChannel& each : noisy_channels("albedo.", 5, 0.5f, 0.2f)) {
            ForeignChannel& guide = channels.emplace_back(each);
            guide.type = Imf::FLOAT;
            for (float& value : guide.values) value *= size;
            ForeignChannel& mse = channels.emplace_back(guide);
            mse.name.insert(6, "_mse");
            for (float& value : mse.values) value = noise * (value - 0.5f * size);
        }
        write_foreign(folder.path("guided.exr"), channels, 40, 30);
        REQUIRE(run_raylex(folder, "denoise guided.exr -o out.exr").code == 0);
        return scatter(*display::read_exr(folder.path("out.exr")), "", 1);
    };
    // 0.04 before. Without a guide the filter leaves less than 0.008; a guide of noise allows no step for the worse.
    CHECK(denoised(1e37f, 1) < 0.008);
    CHECK(denoised(1, 1) < 0.04);
}

}  // namespace raylex::test
