// Cryptomattes of rendered scenes: coverage, sums equal to alpha, the same bits for any number of threads.
#include "transport/render_support.h"

#include <algorithm>
#include <bit>
#include <map>

#include "geoaovs/cryptomatte.h"

using namespace render_test;
using raylex::geoaovs::Cryptomatte;
using raylex::geoaovs::matte_id;
using raylex::geoaovs::MatteKind;

namespace {

/// A floor, a fence with cutouts of constant alpha, two instances of a pair, and sky between them.
const std::string yard = R"(
Film "rgb" "integer xresolution" 24 "integer yresolution" 24
Sampler "independent" "integer pixelsamples" 32
PixelFilter "gaussian"
LookAt 0 1 -6  0 1 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
MakeNamedMaterial "grass" "string type" "diffuse"
MakeNamedMaterial "wood" "string type" "diffuse"
NamedMaterial "grass"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 0 -9 9 0 -9 9 0 9 -9 0 9]
NamedMaterial "wood"
Shape "bilinearmesh" "point3 P" [-2 0 -2 1 0 -2 -2 1.5 -2 1 1.5 -2] "float alpha" 0.5
ObjectBegin "pair"
  Shape "sphere" "float radius" 0.4
  Translate 0 0.7 0
  Material "conductor"
  Shape "sphere" "float radius" 0.3
ObjectEnd
Translate -0.6 0.4 0
ObjectInstance "pair"
Translate 1.3 0.3 0
ObjectInstance "pair"
)";

transport::RenderOutput render_yard(int threads, const std::vector<raylex::transport::LabelRule>& rules = {},
                                    int ranks = 6) {
    auto scene = scene_of(yard);
    REQUIRE(transport::apply_label_rules(scene, rules));
    transport::RenderSettings settings;
    settings.machine.threads = threads;
    settings.mattes.kinds = {MatteKind::object, MatteKind::material, MatteKind::asset};
    settings.mattes.ranks = ranks;
    return render_of(scene, settings);
}

std::vector<std::string> names_of(const Cryptomatte& matte) {
    std::vector<std::string> names;
    for (const auto& [key, value] : matte.attributes())
        if (key.ends_with("/manifest"))
            for (std::size_t at = value.find('"'); at != std::string::npos; at = value.find('"', at + 1)) {
                const std::size_t end = value.find('"', at + 1);
                const std::string text = value.substr(at + 1, end - at - 1);
                if (value[end + 1] == ':') names.push_back(text);
                at = end;
            }
    return names;
}

}  // namespace

TEST_CASE("coverages of objects, materials and assets sum to alpha", "[cryptomatte][render]") {
    const auto output = render_yard(2);
    REQUIRE(output.cryptomatte.size() == 3);
    const std::vector<double> alpha = output.frame_buffer.resolve_alpha();
    CHECK(*std::min_element(alpha.begin(), alpha.end()) == 0);
    for (const Cryptomatte& matte : output.cryptomatte) {
        CAPTURE(matte.name());
        const std::vector<float> values = matte.values();
        for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel) {
            double sum = 0;
            for (std::size_t rank = 0; rank < 6; ++rank) {
                const float coverage = values[(2 * rank + 1) * alpha.size() + pixel];
                sum += static_cast<double>(coverage);
                CHECK((coverage > 0) == (values[2 * rank * alpha.size() + pixel] != 0));
            }
            CHECK(sum == Approx(alpha[pixel]).margin(1e-4));  // the limit in this project's specification
        }
        CHECK(matte.remainder().pixels == 0);
    }
    CHECK(names_of(output.cryptomatte[0]) ==
          std::vector<std::string>{"bilinearmesh:0", "pair/sphere:0", "pair/sphere:1", "trianglemesh:0"});
    CHECK(names_of(output.cryptomatte[1]) == std::vector<std::string>{"conductor:0", "grass", "wood"});
    CHECK(names_of(output.cryptomatte[2]) ==
          std::vector<std::string>{"bilinearmesh:0", "pair:0", "pair:1", "trianglemesh:0"});
}

TEST_CASE("coverage beyond the ranks is the remainder of alpha", "[cryptomatte][render]") {
    const auto output = render_yard(2, {}, 2);
    const std::vector<double> alpha = output.frame_buffer.resolve_alpha();
    const Cryptomatte& matte = output.cryptomatte[0];
    const std::vector<float> values = matte.values();
    double largest = 0;
    for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel)
        largest = std::max(largest, alpha[pixel] - static_cast<double>(values[alpha.size() + pixel]) -
                                        static_cast<double>(values[3 * alpha.size() + pixel]));
    CHECK(largest > 0.01);  // sky, fence, floor and two spheres share a pixel somewhere
    CHECK(matte.remainder().largest == Approx(largest).margin(1e-6));
}

TEST_CASE("a half-transparent surface covers half of a pixel, and the surface behind it the other half",
          "[cryptomatte][render]") {
    const auto scene = scene_of(R"(
Film "rgb" "integer xresolution" 16 "integer yresolution" 16
Sampler "independent" "integer pixelsamples" 64
Camera "perspective" "float fov" 20
WorldBegin
Shape "disk" "float radius" 50 "float height" 20
Shape "bilinearmesh" "point3 P" [-9 -9 5 9 -9 5 -9 9 5 9 9 5] "float alpha" 0.25
)");
    transport::RenderSettings settings;
    settings.mattes.kinds = {MatteKind::object};
    const auto output = render_of(scene, settings);
    std::map<std::uint32_t, double> mean;
    const std::vector<float> values = output.cryptomatte[0].values();
    for (std::size_t pixel = 0; pixel < 256; ++pixel)
        for (std::size_t rank = 0; rank < 6; ++rank)
            mean[std::bit_cast<std::uint32_t>(values[2 * rank * 256 + pixel])] +=
                static_cast<double>(values[(2 * rank + 1) * 256 + pixel]) / 256;
    // 16384 choices of probability 1/4: a standard deviation of 0.0034, times 4.
    CHECK(mean[matte_id("bilinearmesh:0")] == Approx(0.25).margin(0.0135));
    CHECK(mean[matte_id("disk:0")] == Approx(0.75).margin(0.0135));
    CHECK(mean.size() == 3);  // and the empty ranks
}

TEST_CASE("mattes are bit-identical for any number of threads, and do not change the beauty",
          "[cryptomatte][law2][law3]") {
    const auto one = render_yard(1), three = render_yard(3);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::vector<float> a = one.cryptomatte[i].values(), b = three.cryptomatte[i].values();
        CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
            return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
        }));
    }
    const auto without = render_of(scene_of(yard));
    CHECK(without.cryptomatte.empty());
    CHECK(without.frame_buffer.resolve(without.beauty) == one.frame_buffer.resolve(one.beauty));
}

TEST_CASE("labels name objects; holdouts have no matte, since they have no alpha", "[cryptomatte][render]") {
    raylex::transport::LabelRule label, holdout;
    label.selector = raylex::transport::LabelRule::Selector::material;
    label.pattern = "grass";
    label.label = "ground";
    holdout.selector = raylex::transport::LabelRule::Selector::material;
    holdout.pattern = "wood";
    holdout.holdout = true;
    holdout.keeps_label = true;
    const auto output = render_yard(2, {label, holdout});
    const std::vector<std::string> names = names_of(output.cryptomatte[0]);
    CHECK(std::count(names.begin(), names.end(), "ground") == 1);
    const std::vector<float> values = output.cryptomatte[0].values();
    const std::vector<double> alpha = output.frame_buffer.resolve_alpha();
    for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel) {
        double sum = 0;
        for (std::size_t rank = 0; rank < 6; ++rank) {
            const std::uint32_t id = std::bit_cast<std::uint32_t>(values[2 * rank * alpha.size() + pixel]);
            CHECK(id != matte_id("bilinearmesh:0"));  // the fence is of wood, and so are the lower spheres
            sum += static_cast<double>(values[(2 * rank + 1) * alpha.size() + pixel]);
        }
        CHECK(sum == Approx(alpha[pixel]).margin(1e-4));
    }
}

TEST_CASE("a label equal to the material's name also names objects", "[cryptomatte][render]") {
    raylex::transport::LabelRule label;
    label.selector = raylex::transport::LabelRule::Selector::material;
    label.pattern = label.label = "grass";
    const std::vector<std::string> labelled = names_of(render_yard(1, {label}).cryptomatte[0]),
                                   plain = names_of(render_yard(1, {}).cryptomatte[0]);
    CHECK(std::count(labelled.begin(), labelled.end(), "grass") == 1);
    CHECK(std::count(plain.begin(), plain.end(), "grass") == 0);
}

TEST_CASE("kernels with negative lobes and odd ranks are refused", "[cryptomatte][law7]") {
    transport::RenderSettings settings;
    settings.mattes.kinds = {MatteKind::object};
    raylex::transport::SceneEntity filter;
    filter.type = "mitchell";
    filter.location = {"job.toml", 7, 3};
    settings.film.filter = filter;
    const auto negative = transport::render(scene_of(yard), settings);
    REQUIRE_FALSE(negative.ok());
    CHECK(negative.error().file == "job.toml");
    CHECK(negative.error().line == 7);
    CHECK(negative.error().message.find("'mitchell' has negative lobes") != std::string::npos);
    settings.film.filter.reset();
    for (const int ranks : {0, 3, 34}) {
        settings.mattes.ranks = ranks;
        const auto odd = transport::render(scene_of(yard), settings);
        REQUIRE_FALSE(odd.ok());
        CHECK(odd.error().message.find("even number from 2 to 32") != std::string::npos);
    }
}
