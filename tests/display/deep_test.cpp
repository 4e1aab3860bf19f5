#include "display/deep/deep_buffer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include <ImfCompositeDeepScanLine.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfStringAttribute.h>

#include "display/output/writer/deep_file.h"
#include "files.h"

using namespace raylex::display;
using raylex::RgbD;
using raylex::test::Folder;

namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

std::vector<ChannelDefinition> deep_channels() {
    std::vector<ChannelDefinition> list(2);
    list[0].name = "beauty";
    list[1].name = "diffuse";
    list[0].style = list[1].style = ChannelStyle::expression;
    return list;
}

/// One row of a sample, as AddSample, WriteDistance and Splat make it.
struct Hit {
    float depth;
    double opacity, light;
    bool volume = false;
};
using Sample = std::vector<Hit>;

/// Passes samples to a sink like a render: blocks of 16, with the first hit in the camera row and the others added.
void give(SampleSink& sink, FrameBuffer* frame_buffer, const std::vector<Sample>& samples, int x, int y,
          std::uint64_t first = 0) {
    const auto list = deep_channels();
    SampleTable table(list, 16);
    for (std::size_t begin = 0; begin < samples.size(); begin += 16) {
        std::vector<CameraRow> rows(std::min<std::size_t>(16, samples.size() - begin));
        for (std::size_t i = 0; i < rows.size(); ++i) {
            rows[i].pixel_x = x;
            rows[i].pixel_y = y;
            rows[i].sample = first + begin + i;
        }
        table.begin(rows);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            bool camera = true;
            for (const Hit& hit : samples[begin + i]) {
                const auto row =
                    static_cast<std::size_t>(camera ? static_cast<int>(i) : table.add_row(static_cast<int>(i)));
                camera = false;
                table.depth[row] = hit.depth;
                table.opacity[row] = RgbD(hit.opacity);
                table.is_volume[row] = hit.volume ? 1 : 0;
                for (ChannelId id = 0; id < 2; ++id) {
                    table.touch(id);
                    for (std::size_t c = 0; c < 3; ++c)
                        table.raw_values(id)[3 * row + c] =
                            hit.light * (id == 0 ? 1.0 : 0.5) * (1.0 + 0.1 * static_cast<double>(c));
                }
            }
        }
        sink.accumulate(table);
        if (frame_buffer != nullptr) frame_buffer->accumulate(table);
    }
}

std::vector<DeepSample> pixel_of(const std::vector<Sample>& samples, const DeepOptions& options = {}) {
    DeepBuffer deep(1, 1, deep_channels(), {0}, options);
    give(deep, nullptr, samples, 0, 0);
    return deep.resolve(0, 0);
}

double flat_alpha(const std::vector<DeepSample>& samples) {
    double through = 1;
    for (const DeepSample& sample : samples) through *= 1 - static_cast<double>(sample.alpha);
    return 1 - through;
}

/// A pixel with surfaces at slanted depths, cutouts, fog and sky, and light everywhere; reproducible by the seed.
std::vector<Sample> busy_pixel(unsigned seed, int count) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    std::vector<Sample> samples;
    for (int i = 0; i < count; ++i) {
        Sample sample;
        if (uniform() < 0.3) sample.push_back({static_cast<float>(2 + uniform()), 1, uniform(), true});
        else if (uniform() < 0.2) sample.push_back({infinite, 0, 0.3 * uniform()});
        else sample.push_back({static_cast<float>(5 + 20 * uniform()), uniform() < 0.8 ? 1 : 0.5, uniform()});
        while (uniform() < 0.3) sample.push_back({static_cast<float>(1 + 30 * uniform()), uniform(), 0.1 * uniform()});
        samples.push_back(sample);
    }
    return samples;
}

struct Rendered {
    DeepBuffer deep;
    FrameBuffer flat;
};

Rendered rendered(const DeepOptions& options, int size = 12, int count = 64) {
    Rendered result{DeepBuffer(size, size, deep_channels(), {0, 1}, options),
                    FrameBuffer({size, size}, deep_channels())};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            give(result.deep, &result.flat, busy_pixel(static_cast<unsigned>(y * size + x), count), x, y);
    return result;
}

}  // namespace

TEST_CASE("half-covered pixels keep their alpha when flattened", "[display][deep]") {
    // Two opaque samples of half weight at two depths: the alphas are 1/2 and 1, not 1/2 and 1/2 (which would give
    // 3/4).
    const auto two = pixel_of({{{2, 1, 1}}, {{4, 1, 3}}});
    REQUIRE(two.size() == 2);
    CHECK(two[0].z == 2);
    CHECK(two[0].alpha == 0.5f);
    CHECK(two[0].values[0] == 0.5f);
    CHECK(two[1].z == 4);
    CHECK(two[1].alpha == 1);
    CHECK(two[1].values[0] == 3);  // half the samples, behind half the transmittance

    std::vector<Sample> sixteen;
    for (int i = 0; i < 16; ++i) sixteen.push_back({{static_cast<float>(1 << (i % 8)), 1, 1}});
    CHECK(flat_alpha(pixel_of(sixteen)) == Approx(1).epsilon(1e-6));  // 8 float alphas

    // Without a hit there is no sample. An environment gives one sample, far away, that hides nothing.
    CHECK(pixel_of({{{infinite, 0, 0}}}).empty());
    const auto sky = pixel_of({{{2, 1, 1}}, {{infinite, 0, 5}}});
    REQUIRE(sky.size() == 2);
    CHECK(sky[1].z == deep_background);
    CHECK(sky[1].alpha == 0);
    CHECK(sky[1].values[0] == 5);
}

TEST_CASE("extra rows get a share of the transmittance of the rows in front", "[display][deep]") {
    const auto samples = pixel_of({{{3, 1, 4}, {1, 0.25, 1}, {2, 0.5, 2}}});  // in any order of rows
    REQUIRE(samples.size() == 3);
    CHECK(samples[0].z == 1);
    CHECK(samples[0].alpha == 0.25f);
    CHECK(samples[1].alpha == 0.5f);
    CHECK(samples[2].alpha == 1);
    CHECK(samples[1].values[0] == Approx(2 / 0.75));  // divided by the transmittance in front
    CHECK(samples[2].values[0] == Approx(4 / 0.375));
    CHECK(flat_alpha(samples) == 1);
}

TEST_CASE("volume scattering becomes spans, surfaces stay points", "[display][deep]") {
    std::vector<Sample> samples;
    for (int i = 0; i < 64; ++i)
        samples.push_back(i % 2 == 0 ? Sample{{static_cast<float>(1 + i / 64.0), 1, 1, true}} : Sample{{4, 1, 1}});
    DeepOptions coarse;
    coarse.tolerance = 0.5;
    const auto merged = pixel_of(samples, coarse);
    REQUIRE(merged.size() >= 2);
    CHECK(merged.front().z == 1);
    CHECK(merged.front().z_back > merged.front().z);
    CHECK(merged.front().alpha < 1);
    CHECK(merged.back().z == 4);
    CHECK(merged.back().z_back == 4);
    CHECK(flat_alpha(merged) == Approx(1).epsilon(1e-6));
}

TEST_CASE("deep pixels flatten to the shallow image within the bound", "[display][deep]") {
    const Folder folder;
    for (const char* storage : {"zips", "half rle", "none"})
        for (const bool tidy : {false, true}) {
            CAPTURE(storage, tidy);
            DeepOptions options;
            options.tidy = tidy;
            const Rendered image = rendered(options);
            REQUIRE(write_exr(folder.path("flat.exr"), image.flat, 0, {}).ok());
            const auto written =
                write_deep_exr(folder.path("deep.exr"), image.deep, 0, {}, *parse_deep_storage(storage, {}));
            if (!written) FAIL(written.error().message);
            const auto flat = read_exr(folder.path("flat.exr"));
            REQUIRE(flat.ok());
            const auto verdict = check_deep(folder.path("deep.exr"), *flat);
            if (!verdict) FAIL(verdict.error().message);
            CHECK(verdict->holds);
            CHECK(verdict->sorted);
            CHECK(verdict->layers == std::vector<std::string>{"beauty", "diffuse"});
            CHECK(verdict->most_samples <= 33);
            CHECK(verdict->largest_alpha > 0);  // floats were rounded, so the check is meaningful
        }
}

TEST_CASE("deep colours beyond their type are counted, and clamp as in a flat image", "[display][deep][law6]") {
    const Folder folder;
    const DeepStorage half = *parse_deep_storage("half", {}), single;
    const auto rendered_with = [](double light) {
        Rendered image{DeepBuffer(2, 1, deep_channels(), {0, 1}, {}), FrameBuffer({2, 1}, deep_channels())};
        give(image.deep, &image.flat, {{{2, 1, light}}, {{infinite, 0, light}}}, 0, 0);
        give(image.deep, &image.flat, {{{3, 1, 0.5}}}, 1, 0);
        return image;
    };
    const Rendered bright = rendered_with(1e6), dim = rendered_with(1e4);
    const auto write_flat = [&](StoredType type) {
        ImageDescription description;
        for (ExrStorage& each : description.storage) each.type = type;
        REQUIRE(write_exr(folder.path("flat.exr"), bright.flat, 0, description).ok());
    };
    const auto checked = [&](const DeepBuffer& deep, const DeepStorage& storage) {
        std::map<std::string, std::string> repaired;
        REQUIRE(write_deep_exr(folder.path("deep.exr"), deep, 0, {}, storage, &repaired).ok());
        return std::pair(*check_deep(folder.path("deep.exr"), *read_exr(folder.path("flat.exr"))), repaired);
    };
    write_flat(StoredType::single_float);
    const auto [verdict, repaired] = checked(bright.deep, half);
    CHECK(verdict.holds);
    CHECK(verdict.clamped == 1);
    const std::string six = "0 values not a number, set to 0; 6 beyond half, set to the largest";
    CHECK(repaired == std::map<std::string, std::string>{{"repaired/beauty", six}, {"repaired/diffuse", six}});
    {
        Imf::DeepScanLineInputFile file(folder.path("deep.exr").c_str());
        const auto* counted = file.header().findTypedAttribute<Imf::StringAttribute>("repaired/diffuse");
        REQUIRE(counted != nullptr);
        CHECK(counted->value() == six);
    }
    const auto [as_float, none] = checked(bright.deep, single);
    CHECK(as_float.holds);
    CHECK(as_float.clamped == 0);
    CHECK(none.empty());
    write_flat(StoredType::half_float);
    const auto [flat_clamped, no_more] = checked(bright.deep, single);
    CHECK(flat_clamped.holds);
    CHECK(flat_clamped.clamped == 1);
    // 65504 means at least 65504, but 1e4 does not.
    CHECK(checked(dim.deep, single).first.exceeding == 1);
}

TEST_CASE("deep light has the scale of its channel, like the image", "[display][deep][law6]") {
    std::vector<ChannelDefinition> channels = deep_channels();
    for (ChannelDefinition& channel : channels) channel.scale_exponent = 100;
    DeepBuffer deep(1, 1, channels, {0}, {});
    give(deep, nullptr, {{{2, 1, 1e33}}}, 0, 0);  // beyond the sums of scale 0, which end at 2^47
    CHECK(deep.counts().refused_rows == 0);
    REQUIRE(deep.resolve(0, 0).size() == 1);
    CHECK(deep.resolve(0, 0)[0].values[0] == Approx(1e33f));
}

TEST_CASE("flattening by the library's own compositor agrees", "[display][deep]") {
    // OpenEXR's compositor, which is independent of the way samples were made: it sorts, splits and merges by the
    // specification of deep pixels. Tidy pixels need no interpretation.
    const Folder folder;
    DeepOptions options;
    options.tidy = true;
    const Rendered image = rendered(options);
    REQUIRE(write_deep_exr(folder.path("deep.exr"), image.deep, 0, {}, {}).ok());
    Imf::DeepScanLineInputFile file(folder.path("deep.exr").c_str());
    const auto* state = file.header().findTypedAttribute<Imf::DeepImageStateAttribute>("deepImageState");
    REQUIRE(state != nullptr);
    CHECK(state->value() == Imf::DIS_TIDY);
    std::vector<float> red(144), alpha(144);
    Imf::FrameBuffer target;
    target.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(red.data()), 4, 48));
    target.insert("A", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha.data()), 4, 48));
    Imf::CompositeDeepScanLine compositor;
    compositor.addSource(&file);
    compositor.setFrameBuffer(target);
    compositor.readPixels(0, 11);
    const auto beauty = image.flat.resolve(0), coverage = image.flat.resolve_alpha();
    for (std::size_t i = 0; i < 144; ++i) {
        CHECK(alpha[i] == Approx(coverage[i]).margin(4e-6));   // 33 samples of 2^-23
        CHECK(red[i] == Approx(beauty[3 * i]).epsilon(2e-5));  // the same bound, behind little transmittance
    }
}

TEST_CASE("the order of batches does not matter", "[display][deep][law3]") {
    for (const int limit : {4, 32}) {
        DeepOptions options;
        options.most_samples = limit;
        const std::vector<Sample> samples = busy_pixel(7, 128);
        std::vector<std::vector<DeepSample>> results;
        for (int order = 0; order < 3; ++order) {
            DeepBuffer deep(1, 1, deep_channels(), {0, 1}, options);
            for (int k = 0; k < 8; ++k) {
                const int block = order == 0 ? k : order == 1 ? 7 - k : (k * 3) % 8;
                const std::vector<Sample> part(samples.begin() + 16 * block, samples.begin() + 16 * (block + 1));
                give(deep, nullptr, part, 0, 0, static_cast<std::uint64_t>(16 * block));
            }
            results.push_back(deep.resolve(0, 0));
        }
        for (int order = 1; order < 3; ++order) {
            REQUIRE(results[static_cast<std::size_t>(order)].size() == results[0].size());
            for (std::size_t i = 0; i < results[0].size(); ++i) {
                const DeepSample &a = results[0][i], &b = results[static_cast<std::size_t>(order)][i];
                CHECK(a.z == b.z);
                CHECK(a.z_back == b.z_back);
                CHECK(a.alpha == b.alpha);
                CHECK(a.values == b.values);
            }
        }
    }
}

TEST_CASE("memory per pixel is bounded, and merging is counted", "[display][deep]") {
    DeepOptions options;
    options.most_samples = 3;
    options.tolerance = 0x1p-20;
    DeepBuffer deep(2, 1, deep_channels(), {0}, options);
    std::vector<Sample> many;
    for (int i = 0; i < 1000; ++i) many.push_back({{static_cast<float>(1 + 0.01 * i), 1, 1}});
    give(deep, nullptr, many, 0, 0);
    give(deep, nullptr, {{{2, 1, 1}}, {{3, 1, 1}}}, 1, 0);
    CHECK(deep.resolve(0, 0).size() <= 3);
    CHECK(flat_alpha(deep.resolve(0, 0)) == Approx(1).epsilon(1e-6));
    CHECK(deep.resolve(1, 0).size() == 2);
    const DeepCounts counts = deep.counts();
    CHECK(counts.merged_pixels == 1);
    CHECK(counts.coarsest >= 0.5);  // depths from 1 to 11 in three bins
    CHECK(counts.refused_rows == 0);
    give(deep, nullptr, {{{-1, 1, 1}}}, 1, 0);
    CHECK(deep.counts().refused_rows == 1);
}

TEST_CASE("tidy pixels do not overlap, sorted ones may", "[display][deep]") {
    for (const bool tidy : {false, true}) {
        DeepOptions options;
        options.tidy = tidy;
        options.tolerance = 1;
        options.most_samples = 4;
        for (unsigned seed = 0; seed < 50; ++seed) {
            const auto samples = pixel_of(busy_pixel(seed, 64), options);
            for (std::size_t i = 0; i < samples.size(); ++i) {
                CHECK(samples[i].z_back >= samples[i].z);
                if (i == 0) continue;
                CHECK(samples[i].z >= samples[i - 1].z);
                if (tidy) CHECK(samples[i].z >= samples[i - 1].z_back);
                if (tidy && samples[i - 1].z == samples[i - 1].z_back) CHECK(samples[i].z > samples[i - 1].z);
            }
        }
    }
}

TEST_CASE("a deep file that does not flatten to the image is detected", "[display][deep]") {
    const Folder folder;
    const Rendered image = rendered({});
    Rendered other{DeepBuffer(12, 12, deep_channels(), {0, 1}, {}), FrameBuffer({12, 12}, deep_channels())};
    for (int i = 0; i < 144; ++i)
        give(other.deep, &other.flat, busy_pixel(static_cast<unsigned>(i), i == 70 ? 63 : 64), i % 12, i / 12);
    REQUIRE(write_exr(folder.path("flat.exr"), image.flat, 0, {}).ok());
    REQUIRE(write_deep_exr(folder.path("deep.exr"), other.deep, 0, {}, {}).ok());
    const auto flat = read_exr(folder.path("flat.exr"));
    const auto verdict = check_deep(folder.path("deep.exr"), *flat);
    REQUIRE(verdict.ok());
    CHECK(!verdict->holds);
    CHECK(verdict->exceeding == 1);
    CHECK(verdict->color_x == 10);
    CHECK(verdict->color_y == 5);

    CHECK(check_deep(folder.path("flat.exr"), *flat).error().message.find("no deep scanline part") !=
          std::string::npos);
    CHECK(!check_deep(folder.path("none.exr"), *flat).ok());
    const std::string bytes = raylex::test::read_bytes(folder.path("deep.exr"));
    for (const std::size_t length : {bytes.size() / 2, bytes.size() - 100}) {
        raylex::test::write_bytes(folder.path("cut.exr"), bytes.substr(0, length));
        CHECK(!check_deep(folder.path("cut.exr"), *flat).ok());
    }
}

TEST_CASE("channels that cannot be deep are refused before rendering", "[display][deep][law7]") {
    auto list = deep_channels();
    list.resize(4);
    list[2].name = "id";
    list[2].type = ChannelType::integer;
    list[3].name = "z";
    list[3].rule = FilterRule::zmin;
    const auto message = [&](std::vector<ChannelId> chosen, DeepOptions options = {}) {
        const auto status = DeepBuffer::check(list, chosen, options);
        return status.ok() ? std::string() : status.error().message;
    };
    CHECK(message({0, 1}).empty());
    CHECK(message({2}).find("an integer") != std::string::npos);
    CHECK(message({3}).find("not a filtered mean") != std::string::npos);
    DeepOptions wrong;
    wrong.most_samples = 0;
    CHECK(message({0}, wrong).find("1 to 4096") != std::string::npos);
    wrong = {};
    wrong.tolerance = std::nan("");
    CHECK(message({0}, wrong).find("tolerance") != std::string::npos);
    for (const char* text : {"zip", "piz", "", "half dwaa"}) {
        CAPTURE(text);
        CHECK(!parse_deep_storage(text, {}).ok());
    }
}
