// Sums of layers in users' notation, and their bounds for rounding and compression.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include <ImfInputFile.h>

#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/split_check.h"
#include "display/output/splits/split_sum.h"
#include "display/output/splits/stored_precision.h"
#include "files.h"

using namespace raylex::test;
using raylex::display::Allowance;
using raylex::display::check_split;
using raylex::display::ExrImage;
using raylex::display::SplitAnswer;
using raylex::display::SplitResult;
using raylex::display::StoredType;

namespace {

ExrImage values(std::vector<std::pair<std::string, float>> layers, StoredType type = StoredType::single_float) {
    std::vector<raylex::display::ImageLayer> all;
    for (const auto& [name, value] : layers) all.push_back(color_layer(name, {{value, value, value}}, type));
    return image_of(1, 1, std::move(all));
}

SplitResult run_checks(const ExrImage& image, const std::string& sum, const std::string& of = "") {
    auto result = check_split(image, of, {sum});
    if (!result) FAIL(result.error().to_string());
    return *result;
}

raylex::Error refusal(const ExrImage& image, const std::string& sum, const std::string& of = "") {
    const auto result = check_split(image, of, {sum});
    if (result) FAIL("accepted: " << sum);
    return result.error();
}

/// The value of a sum: the value of `of` for which the difference is 0.
double value_of(const std::string& sum) {
    ExrImage image = values({{"", 0}, {"a", 2}, {"b", 3}, {"c", 5}, {"d-e", 7}, {"a b", 11}, {"x*", 13}, {"a-b", 17}});
    return run_checks(image, sum).largest_absolute;
}

}  // namespace

TEST_CASE("sums of layers follow the rules of arithmetic", "[display][verify]") {
    CHECK(value_of("a") == 2);
    CHECK(value_of("a,b,c") == 10);
    CHECK(value_of("a+b*c") == 17);
    CHECK(value_of("(a+b)*c") == 25);
    CHECK(value_of("(a + b) * c , a") == 27);
    CHECK(value_of("c-b-a") == 0);
    CHECK(value_of("c - (b - a)") == 4);
    CHECK(value_of("c - -a") == 7);
    CHECK(value_of("-(a - c)*b") == 9);
    CHECK(value_of("a*b*c") == 30);
    CHECK(value_of("((((a))))") == 2);
    // A layer that several names and globs give counts once; in expressions it counts each time.
    CHECK(value_of("a,a,?") == 10);
    CHECK(value_of("a+a,a") == 6);
    // Names with any characters: in quotes, or if the longest matching name is meant.
    CHECK(value_of("d-e") == 7);
    CHECK(value_of("a b*a") == 22);
    CHECK(value_of("'a b' * \"d-e\"") == 77);
    CHECK(value_of("a-b + a") == 19);
    CHECK(value_of("c - b + a") == 4);
    CHECK(value_of("'x*'*a") == 26);
}

TEST_CASE("errors in a sum give the column", "[display][verify][law7]") {
    const ExrImage image = values({{"", 0}, {"DiffDir", 2}, {"DiffCol", 3}, {"Emit", 5}});
    struct Case {
        const char* sum;
        int column;
        const char* text;
    };
    for (const Case& wrong : {Case{"(DiffDir*DiffCol", 1, "never closed"},
                              {"DiffDir)", 8, "is unexpected here"},
                              {"DiffDir+", 9, "expected a layer or ("},
                              {"DiffDir*DiffCol,", 17, "this item is empty"},
                              {"", 1, "is empty"},
                              {"DiffDir, ,Emit", 10, "is empty"},
                              {"DiffDir*+", 10, "expected a layer or ("},
                              {"Emit, 'DiffDir", 7, "quote"},
                              {"()", 2, "expected a layer or ("},
                              {"DiffDir DiffCol", 9, "is unexpected here"},
                              {"DiffDri*DiffCol", 1, "no layer 'DiffDri'"},
                              {"Emit, (DiffDir+DifCol)", 16, "no layer 'DifCol'"},
                              {"Emit, rgba*DiffCol", 7, "is the sum itself"},
                              {"beauty", 1, "is the sum itself"}}) {
        CAPTURE(wrong.sum);
        const raylex::Error error = refusal(image, wrong.sum);
        CHECK(error.column == wrong.column);
        CHECK(error.excerpt == wrong.sum);
        CHECK(error.message.find(wrong.text) != std::string::npos);
    }
    CHECK(refusal(image, "DiffDri*DiffCol").hint == "did you mean 'DiffDir'?");
    CHECK(refusal(image, "emit").hint == "did you mean 'Emit'?");
    CHECK(refusal(image, "Diff").hint == "names like it: DiffDir, DiffCol");
    CHECK(refusal(image, "Emti*").message.find("no layer matches 'Emti*'") != std::string::npos);
    CHECK(refusal(image, std::string(5000, '(')).message.find("64 brackets") != std::string::npos);
}

TEST_CASE("names can omit the prefix of the application", "[display][verify]") {
    ExrImage image = values({{"View Layer.Combined", 6},
                             {"View Layer.DiffDir", 2},
                             {"View Layer.DiffCol", 3},
                             {"View Layer.Combined_a", 6}});
    CHECK(run_checks(image, "DiffDir*DiffCol", "Combined").holds);
    CHECK(run_checks(image, "View Layer.DiffDir * DiffCol", "View Layer.Combined").holds);
    CHECK(run_checks(image, "Combined_*", "Combined").layers == std::vector<std::string>{"View Layer.Combined_a"});
    CHECK(run_checks(image, "*Dif*Col", "DiffDir").layers == std::vector<std::string>{"View Layer.DiffCol"});
    CHECK(refusal(image, "DiffDri*DiffCol", "Combined").hint == "did you mean 'DiffDir'?");
    // If several layers match, the one with the prefix of the split layer is taken.
    for (const char* name : {"Combined", "DiffDir", "DiffCol", "Combined_a"})
        image.layers.push_back(color_layer("Second." + std::string(name), {{9, 9, 9}}));
    CHECK(run_checks(image, "DiffDir", "Second.Combined").layers == std::vector<std::string>{"Second.DiffDir"});
    CHECK(run_checks(image, "Combined_*", "Second.Combined").layers == std::vector<std::string>{"Second.Combined_a"});
    const raylex::Error several = refusal(image, "DiffDir", "Combined");
    CHECK(several.message ==
          "several layers are called 'Combined'; expected one of: View Layer.Combined, Second.Combined");
    // Files with one layer each share the beginning of their names.
    const ExrImage files = values({{"shot-2_beauty", 5}, {"shot-2_diffuse", 2}, {"shot-2_coat", 3}});
    CHECK(run_checks(files, "diffuse,coat", "beauty").holds);
    CHECK(run_checks(files, "*oat,diff*", "beauty").layers.size() == 2);
}

TEST_CASE("products carry the rounding of their factors, and no more", "[display][verify][law1]") {
    // Halves of 1/3 and 3: the product of the true values is 1, that of the stored values is off by half a step of the
    // first.
    const float third = half(1.0f / 3), sum_of_two = half(2.0f / 3);
    const auto of_halves = [](float a, float b, float whole) {
        return run_checks(values({{"", whole}, {"a", a}, {"b", b}}, StoredType::half_float), "a*b");
    };
    CHECK(of_halves(third, 3.0f, 1.0f).answer == SplitAnswer::holds_to_rounding);
    CHECK(of_halves(sum_of_two, 3.0f, 2.0f).holds);
    // One step of each factor and of the product: 3 x 2^-10 of the product 1, and not one per cent.
    CHECK(of_halves(1.0f, 1.0f, 1.0f + 3 * 0x1p-10f).holds);
    CHECK(!of_halves(1.0f, 1.0f, 1.0f + 5 * 0x1p-10f).holds);
    CHECK(of_halves(1.0f, 1.0f, 1.0f).bound == Approx(2 * 0x1p-10).epsilon(1e-3));
    // A large factor increases the absolute bound of the other factor's error, not the relative one.
    CHECK(of_halves(1000.0f, 0.001f, half(1.0f + 3 * 0x1p-10f)).holds);
    CHECK(!of_halves(1000.0f, 0.001f, 1.01f).holds);
    // Factors that are too small for a half: the spacing of the small one times the large one.
    CHECK(of_halves(half(1e-7f), 60000.0f, 0.0072f).holds);
    CHECK(!of_halves(half(1e-7f), 60000.0f, 0.02f).holds);
}

TEST_CASE("each float addition of another writer widens the bound; raylex's own sums are exact",
          "[display][verify][law1]") {
    // 9 layers of 1 against 9 (1 + d): 2^-23 for the stored values, plus 8 x 2^-24 for the additions.
    std::vector<std::pair<std::string, float>> layers{{"", 9.0f + 5 * 0x1p-20f}};
    for (int i = 0; i < 9; ++i) layers.emplace_back("group" + std::to_string(i), 1.0f);
    ExrImage image = values(layers);
    CHECK(run_checks(image, "group*").answer ==
          SplitAnswer::holds_to_rounding);  // 4.8e-6 of 18 x 2^-23 + 72 x 2^-24 = 6.4e-6
    CHECK(run_checks(image, "group*").bound == Approx(0x1p-23 + 8 * 0x1p-24));
    image.attributes["raylex/version"] = "1";
    CHECK(!run_checks(image, "group*").holds);  // of 18 x 2^-23 = 2.1e-6
    CHECK(run_checks(image, "group*").bound == 0x1p-23);
}

TEST_CASE("random products and sums, rounded as renderers round, hold to rounding", "[display][verify][law1]") {
    std::mt19937 random(7);
    std::lognormal_distribution<float> light(0.0f, 3.0f);
    for (const StoredType type : {StoredType::single_float, StoredType::half_float}) {
        const auto stored = [type](float value) {
            return type == StoredType::half_float ? static_cast<float>(half(value)) : value;
        };
        std::size_t past_the_type_alone = 0;
        for (int trial = 0; trial < 2000; ++trial) {
            std::vector<std::pair<std::string, float>> layers{{"", 0}};
            std::string sum;
            float whole = 0;
            for (int term = 0; term < 6; ++term) {
                const float color = 1.0f / (1.0f + light(random)), direct = light(random), indirect = light(random);
                const std::string id = std::to_string(term);
                layers.emplace_back("dir" + id, stored(direct / color));
                layers.emplace_back("ind" + id, stored(indirect / color));
                layers.emplace_back("col" + id, stored(color));
                sum += (term == 0 ? "" : ", ") + ("(dir" + id + "+ind" + id + ")*col" + id);
                whole += direct + indirect;
            }
            layers.front().second = stored(whole);
            const SplitResult result = run_checks(values(layers, type), sum);
            CAPTURE(trial, result.largest_relative, result.bound);
            if (std::isfinite(layers.front().second) && result.non_finite == 0)
                REQUIRE(result.answer == SplitAnswer::holds_to_rounding);
            past_the_type_alone +=
                result.largest_relative > (type == StoredType::half_float ? 0x1p-11 : 0x1p-24) ? 1 : 0;
        }
        CHECK(past_the_type_alone > 0);  // the bound of the arithmetic was needed
    }
}

TEST_CASE("three answers: holds to rounding, holds as allowed, does not hold", "[display][verify]") {
    const ExrImage image = values({{"", 1.0f}, {"a", 1.0f + 1e-5f}});
    CHECK(run_checks(image, "a").answer == SplitAnswer::does_not_hold);
    const auto with = [&image](double absolute, double relative) {
        return *check_split(image, "", {"a"}, Allowance{absolute, relative, "a test", false});
    };
    CHECK(with(0, 4e-6).answer == SplitAnswer::does_not_hold);  // of 2.00001
    const SplitResult allowed = with(0, 6e-6);
    CHECK(allowed.answer == SplitAnswer::holds_as_allowed);
    CHECK(allowed.holds);
    CHECK(allowed.past_rounding == 1);
    CHECK(allowed.exceeding == 0);
    CHECK(allowed.largest_absolute == Approx(1e-5).epsilon(1e-2));
    CHECK(allowed.allowed_for == std::vector<std::string>{"a test"});
    CHECK(with(1.1e-5, 0).answer == SplitAnswer::holds_as_allowed);
    CHECK(with(8e-6, 0).answer == SplitAnswer::does_not_hold);
    const SplitResult exact =
        *check_split(values({{"", 1.0f}, {"a", 1.0f}}), "", {"a"}, Allowance{1, 1, "much", false});
    CHECK(exact.answer == SplitAnswer::holds_to_rounding);
    // If the sum is too small everywhere, a layer is missing, and the result reports it.
    CHECK(run_checks(values({{"", 1.0f}, {"a", 0.5f}}), "a").never_above);
    CHECK_FALSE(run_checks(values({{"", 0.5f}, {"a", 1.0f}}), "a").never_above);
    // It does not report this if something is negative, because then no light need be missing.
    const SplitResult lowered = run_checks(values({{"", 1.0f}, {"a", 1.0f}, {"b", -0.5f}}), "a,b");
    CHECK_FALSE(lowered.never_above);
    CHECK(lowered.negative.pixels == 1);
    CHECK(lowered.negative.lowest == -0.5f);
    CHECK(lowered.negative.layer == "b");
    const SplitResult cancelled = run_checks(values({{"", 0.5f}, {"a", 1.0f}, {"b", -0.5f}}), "a,b");
    CHECK(cancelled.holds);
    CHECK(cancelled.negative.pixels == 1);
    CHECK(run_checks(values({{"", 1.0f}, {"a", 1.0f}}), "a").negative.pixels == 0);
}

TEST_CASE("a clamped value is treated as a bound", "[display][verify][law6]") {
    constexpr float largest = 65504;
    const auto of_halves = [](float whole, float a, float b, const char* sum) {
        return run_checks(values({{"", whole}, {"a", a}, {"b", b}}, StoredType::half_float), sum);
    };
    // A layer of at least 65504 is too large for a whole of 30000, and a term that can be larger is not too small.
    CHECK(of_halves(30000, largest, 10, "a,b").exceeding == 1);
    CHECK(of_halves(30000, largest, 10, "a,b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(largest, 30000, 10, "a,b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(-largest, 30000, 10, "-a,b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(largest, 60000, 60000, "a,b").answer == SplitAnswer::cannot_tell);
    CHECK(of_halves(largest, largest, 10, "a,b").answer == SplitAnswer::cannot_tell);
    // Differences and products reverse the bound.
    CHECK(of_halves(30000, 10, largest, "a-b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(-30000, 10, largest, "a-b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(30000, 2, largest, "a*b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(-30000, -0.25f, largest, "a*b").answer == SplitAnswer::cannot_tell);
    CHECK(of_halves(-10000, -0.25f, largest, "a*b").answer == SplitAnswer::does_not_hold);
    CHECK(of_halves(0, 0, largest, "a*b").answer == SplitAnswer::holds_to_rounding);
    // One decided pixel decides the result; the number of decided pixels is counted.
    const ExrImage two = image_of(2, 1,
                                  {color_layer("", {{largest, largest, largest}, {3, 3, 3}}, StoredType::half_float),
                                   color_layer("a", {{60000, 60000, 60000}, {1, 1, 1}}, StoredType::half_float),
                                   color_layer("b", {{60000, 60000, 60000}, {2, 2, 2}}, StoredType::half_float)});
    const SplitResult result = run_checks(two, "a,b");
    CHECK(result.holds);
    CHECK(result.clamped == 1);
    CHECK(result.checked() == 1);
    CHECK(result.pixels == 2);
    const SplitResult none = of_halves(largest, largest, 10, "a,b");
    CHECK_FALSE(none.holds);
    CHECK(raylex::display::result_attribute(none, 2).starts_with("cannot tell: every pixel is clamped; "));
    CHECK(raylex::display::result_attribute(result, 2).ends_with("1 of 2 judged"));
    // Bands that are checked one by one.
    SplitResult all = none;
    raylex::display::add_rows(all, result, 1);
    CHECK(all.holds);
}

TEST_CASE("values that are not finite are reported with their layer, or as overflow of the sum",
          "[display][verify][law6]") {
    const float inf = std::numeric_limits<float>::infinity();
    CHECK(run_checks(values({{"", 1}, {"a", 1}, {"b", inf}}), "a,b").non_finite_layer == "b");
    CHECK(run_checks(values({{"", std::nanf("")}, {"a", 1}}), "a").non_finite_layer == "beauty");
    CHECK(run_checks(values({{"", 1}, {"a", 0}, {"b", inf}}), "a*b").non_finite == 1);  // 0 x inf is not 0
    CHECK(run_checks(values({{"", 1}, {"a", inf}, {"b", inf}}), "a-b").non_finite == 1);
}

namespace {

struct Stored {
    Imf::PixelType type;
    Imf::Compression compression;
};

/// Writes three layers and their sum, lognormal over six orders of magnitude with black pixels, stored as `stored`.
void write_split(const std::string& path, const Stored& stored) {
    constexpr int width = 61, height = 47;
    std::mt19937 random(3);
    std::lognormal_distribution<float> light(-2.0f, 2.0f);
    std::vector<ForeignChannel> channels;
    for (const char* plane : {"B", "G", "R"}) {
        std::vector<float> sum(width * height);
        for (const char* layer : {"a.", "b.", "c."}) {
            std::vector<float> values(sum.size());
            for (std::size_t i = 0; i < values.size(); ++i) {
                values[i] = i % 7 == 0 ? 0.0f : light(random);
                sum[i] += values[i];
            }
            channels.push_back({layer + std::string(plane), stored.type, values});
        }
        channels.push_back({plane, stored.type, sum});
    }
    Imf::Header header(box(width, height), box(width, height));
    header.compression() = stored.compression;
    const ForeignPixels pixels(channels, box(width, height), header);
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(pixels.buffer());
    file.writePixels(height);
}

}  // namespace

TEST_CASE("a correct split holds in every OpenEXR storage, and a missing layer never does", "[display][verify][exr]") {
    using Answer = SplitAnswer;
    const Folder folder;
    struct Case {
        Stored stored;
        Answer answer;
    };
    for (const Case& each : {Case{{Imf::FLOAT, Imf::NO_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::FLOAT, Imf::ZIP_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::FLOAT, Imf::ZIPS_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::FLOAT, Imf::PIZ_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::FLOAT, Imf::PXR24_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::HALF, Imf::ZIP_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::HALF, Imf::RLE_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::HALF, Imf::PXR24_COMPRESSION}, Answer::holds_to_rounding},
                             {{Imf::FLOAT, Imf::DWAA_COMPRESSION}, Answer::holds_as_allowed},
                             {{Imf::HALF, Imf::DWAA_COMPRESSION}, Answer::holds_as_allowed},
                             {{Imf::HALF, Imf::DWAB_COMPRESSION}, Answer::holds_as_allowed},
                             {{Imf::HALF, Imf::B44_COMPRESSION}, Answer::does_not_hold}}) {
        CAPTURE(each.stored.type, each.stored.compression);
        write_split(folder.path("a.exr"), each.stored);
        const auto image = raylex::display::read_exr(folder.path("a.exr"));
        REQUIRE(image);
        const SplitResult result = run_checks(*image, "a,b,c");
        CAPTURE(result.largest_relative, result.bound, result.exceeding);
        CHECK(result.answer == each.answer);
        CHECK(run_checks(*image, "a,b").answer == Answer::does_not_hold);
        CHECK(result.unexplained.empty() == (each.stored.compression != Imf::B44_COMPRESSION));
        // An explicit allowance replaces the one for compression.
        if (each.answer == Answer::holds_as_allowed)
            CHECK(check_split(*image, "", {"a,b,c"}, Allowance{0, 0, "none", true})->answer == Answer::does_not_hold);
    }
}

TEST_CASE("DWA moves values by less than the allowance, but not much less", "[display][verify][exr][dwa]") {
    constexpr int size = 128;
    const Folder folder;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> even(0.0f, 1.0f);
    std::lognormal_distribution<float> bright(0.0f, 2.0f);
    using Kind =
        float (*)(int, int, std::mt19937&, std::uniform_real_distribution<float>&, std::lognormal_distribution<float>&);
    const auto scale = [](double x) {
        const double a = std::abs(x);
        return std::copysign(a <= 1 ? std::pow(a, 1 / 2.2) : 1 + std::log(a) / 2.2, x);
    };
    const std::vector<std::pair<const char*, Kind>> kinds{
        {"noise", [](int, int, auto& r, auto& e, auto&) { return e(r); }},
        {"bright noise", [](int, int, auto& r, auto&, auto& b) { return b(r); }},
        {"signed noise", [](int, int, auto& r, auto& e, auto&) { return 4 * e(r) - 2; }},
        {"dark noise", [](int, int, auto& r, auto& e, auto&) { return 1e-4f * e(r); }},
        {"fireflies", [](int, int, auto& r, auto& e, auto&) { return e(r) < 0.02f ? 1000 * e(r) : 0.1f * e(r); }},
        {"black and white", [](int, int, auto& r, auto& e, auto&) { return e(r) < 0.5f ? 0.0f : 1.0f; }},
        {"gradient", [](int x, int y, auto&, auto&, auto&) { return static_cast<float>(2 * x + y) / 128; }},
        {"edges", [](int x, int y, auto&, auto&, auto&) { return (x / 37 + y / 23) % 2 != 0 ? 5.0f : 0.02f; }}};
    double most = 0;
    for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT}) {
        for (const auto& [name, kind] : kinds) {
            std::vector<ForeignChannel> channels;
            for (const char* plane : {"L.B", "L.G", "L.R"}) {
                std::vector<float> values;
                for (int i = 0; i < size * size; ++i) values.push_back(kind(i % size, i / size, random, even, bright));
                channels.push_back({plane, type, values});
            }
            Imf::Header header(box(size, size), box(size, size));
            header.compression() = Imf::DWAA_COMPRESSION;
            {
                const ForeignPixels pixels(channels, box(size, size), header);
                Imf::OutputFile file(folder.path("dwa.exr").c_str(), header);
                file.setFrameBuffer(pixels.buffer());
                file.writePixels(size);
            }
            const auto image = raylex::display::read_exr(folder.path("dwa.exr"));
            REQUIRE(image);
            double moved = 0;
            for (const ForeignChannel& channel : channels) {
                const auto* plane = image->layers.front().plane(channel.name.substr(2));
                REQUIRE(plane->loss == raylex::display::PlaneLoss::dwa);
                for (std::size_t i = 0; i < channel.values.size(); ++i)
                    moved = std::max(moved, std::abs(scale(static_cast<double>(plane->values[i])) -
                                                     scale(static_cast<double>(channel.values[i]))));
            }
            CAPTURE(name, type, moved);
            CHECK(moved < raylex::display::dwa_move(45));
            most = std::max(most, moved);
        }
    }
    CHECK(most > raylex::display::dwa_move(45) / 2);
}

TEST_CASE("a change on DWA's scale is the larger of the two directions", "[display][verify]") {
    for (const double value : {0.0, 1e-6, 0.01, 0.5, 0.99, 1.0, 1.01, 30.0, 60000.0}) {
        const double change = raylex::display::dwa_change(value, 0.02);
        CAPTURE(value);
        CHECK(change > 0);
        CHECK(change == raylex::display::dwa_change(-value, 0.02));
        CHECK(change < 0.05 * value + 0.02 * std::pow(value, 1.2 / 2.2) * 2.3 + 2e-4);
    }
    CHECK(raylex::display::dwa_change(1.0, 0.02) == Approx(std::exp(0.044) - 1));
}
