// Cryptomatte: the specification's published facts, planes, manifest, remainder.
#include "geoaovs/cryptomatte.h"

#include <bit>
#include <cmath>
#include <utility>

#include <catch2/catch.hpp>

namespace raylex::geoaovs {
namespace {

TEST_CASE("hashes agree with those published by the specification and its authors", "[cryptomatte]") {
    // "Cryptomatte Specification" 1.2.0, section Metadata: the manifests of its examples. The longer names are from the
    // sample image of the same repository (Psyop/Cryptomatte, sample_images/sidecar_manifest/
    // bunny_CryptoObject_manifest.json); the first of them hashes to 7f8e5296, whose exponent is all ones.
    const std::pair<const char*, std::uint32_t> manifest[] = {{"bunny", 0x13851a76},
                                                              {"default", 0x42c9679f},
                                                              {"bunny_porcelain_mat", 0xb24b26d4},
                                                              {"flowerA.flowerA_petal1.:1065", 0x7f0e5296},
                                                              {"flowerA.flowerA_petal1.:1015", 0x914754e4},
                                                              {"flowerA.flowerA_petal10.:2820", 0xa9ed53a1},
                                                              {"flowerA.flowerA_petal10.:3594", 0x0086fc22},
                                                              {"bush", 0xf763d090}};
    for (const auto& [name, id] : manifest) {
        CAPTURE(name);
        CHECK(matte_id(name) == id);
    }
    CHECK(murmur_hash3("flowerA.flowerA_petal1.:1065") == 0x7f8e5296);
    CHECK(murmur_hash3("") == 0);
    // The same repository, nuke/cryptomatte_utilities_tests.py, class CryptoHashing: names, two of them outside ASCII,
    // and ids as decimal numbers with at least 6 digits.
    const std::pair<const char*, double> floats[] = {
        {"hello", 6.0705627102400005616e-17},
        {"cube", -4.08461912519e+15},
        {"sphere", 2.79018604383e+15},
        {"plane", 3.66557617593e-11},
        {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0", -1.3192631212399999468e-25},
        {"m\xc3\xa4"
         "dchen",
         6.2361298211599995797e+25}};
    for (const auto& [name, value] : floats) {
        CAPTURE(name);
        CHECK(std::bit_cast<float>(matte_id(name)) == static_cast<float>(value));
    }
}

TEST_CASE("no id is an infinity, a denormal or NaN", "[cryptomatte]") {
    int fixed = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::string name = std::string("name").append(std::to_string(i));
        const std::uint32_t id = matte_id(name), hash = murmur_hash3(name);
        REQUIRE(std::isnormal(std::bit_cast<float>(id)));
        if (id != hash) {
            ++fixed;
            CHECK((id ^ hash) == 1u << 23);
        }
    }
    CHECK(fixed > 100);  // 2 exponents in 256: 156 expected, standard deviation 12.5
    CHECK(fixed < 220);
}

MatteNames three_names() {
    return {{"floor", "a \"quoted\" \\ name", "broken \xff\n"}, {0, 1, 0, 2}};
}

TEST_CASE("planes have the specification's names and contain ids as floats and their coverage", "[cryptomatte]") {
    Cryptomatte matte(MatteKind::object, 4, 2, 1, three_names());
    CHECK(matte.name() == "CryptoObject");
    CHECK(matte.planes() == std::vector<std::string>{"CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B",
                                                     "CryptoObject00.A", "CryptoObject01.R", "CryptoObject01.G",
                                                     "CryptoObject01.B", "CryptoObject01.A"});
    const std::uint32_t floor = matte_id("floor"), broken = matte_id("broken \xff\n");
    for (int i = 0; i < 4; ++i) matte.coverage().add_weight(1, 1);
    matte.coverage().add(1, floor, 1, 1);
    matte.coverage().add(1, broken, 1, 1);
    matte.coverage().add(1, floor, 1, 0.5);
    const std::vector<float> values = matte.values();
    REQUIRE(values.size() == 16);
    CHECK(std::bit_cast<std::uint32_t>(values[1]) == floor);
    CHECK(values[3] == 0.375f);
    CHECK(std::bit_cast<std::uint32_t>(values[5]) == broken);
    CHECK(values[7] == 0.25f);
    for (const std::size_t empty : {0, 2, 4, 6, 8, 9, 10, 11, 12, 13, 14, 15}) CHECK(values[empty] == 0);
    CHECK(matte.remainder().largest == 0);
    CHECK(Cryptomatte(MatteKind::material, 22, 1, 1, three_names()).planes()[42] == "CryptoMaterial10.B");
}

TEST_CASE("the header names the hash, the conversion and every name, as JSON", "[cryptomatte]") {
    const Cryptomatte matte(MatteKind::asset, 6, 1, 1, three_names());
    const auto attributes = matte.attributes();
    const std::string key = "cryptomatte/f42029d/";  // the first 7 digits of the hash of "CryptoAsset"
    CHECK(attributes.at(key + "name") == "CryptoAsset");
    CHECK(attributes.at(key + "hash") == "MurmurHash3_32");
    CHECK(attributes.at(key + "conversion") == "uint32_to_float32");
    char expected[200];
    std::snprintf(expected, sizeof expected,
                  R"({"a \"quoted\" \\ name":"%08x","broken \ufffd\u000a":"%08x","floor":"%08x"})",
                  matte_id("a \"quoted\" \\ name"), matte_id("broken \xff\n"), matte_id("floor"));
    CHECK(attributes.at(key + "manifest") == expected);
    for (const auto& [name, value] : attributes) CHECK(name.size() < 32);  // the limit of every OpenEXR reader
}

TEST_CASE("coverage beyond the ranks is reported", "[cryptomatte]") {
    MatteNames names;
    for (std::uint32_t i = 0; i < 5; ++i) {
        names.names.push_back(std::string("part").append(std::to_string(i)));
        names.of_surface.push_back(i);
    }
    Cryptomatte matte(MatteKind::object, 2, 2, 1, names);
    for (int i = 0; i < 8; ++i) matte.coverage().add_weight(0, 1);
    for (std::size_t i = 0; i < 5; ++i) matte.coverage().add(0, matte_id(names.names[i]), 1, i < 2 ? 1 : 0.5);
    CHECK(matte.remainder().largest == 1.5 / 8);
    CHECK(matte.remainder().mean == 1.5 / 16);
    CHECK(matte.remainder().pixels == 1);
    CHECK(matte.attributes().at("raylex/CryptoObject") ==
          "2 ranks; left out: at most 0.188 of a pixel, 1 pixels above 1e-4");
}

TEST_CASE("names that share an id are reported, and a long manifest lists only names in the image", "[cryptomatte]") {
    // Found by a search over "x0", "x1", ...: the first two names with equal hashes.
    std::map<std::uint32_t, std::string> seen;
    MatteNames names;
    for (int i = 0; names.names.empty() && i < 1'000'000; ++i) {
        const std::string name = std::string("x").append(std::to_string(i));
        const auto [other, fresh] = seen.emplace(matte_id(name), name);
        if (!fresh) names.names = {other->second, name};
    }
    REQUIRE(names.names.size() == 2);
    names.of_surface = {0, 1};
    const Cryptomatte pair(MatteKind::object, 2, 1, 1, names);
    REQUIRE(pair.collisions().size() == 1);
    CHECK(pair.collisions()[0] == std::pair(names.names[0], names.names[1]));

    MatteNames many;
    for (std::uint32_t i = 0; i <= Cryptomatte::most_manifest_names; ++i) {
        many.names.push_back(std::to_string(i));
        many.of_surface.push_back(i);
    }
    Cryptomatte large(MatteKind::object, 2, 1, 1, many);
    large.coverage().add(0, matte_id("12345"), 1, 1);
    char expected[40];
    std::snprintf(expected, sizeof expected, R"({"12345":"%08x"})", matte_id("12345"));
    CHECK(large.attributes().at("cryptomatte/3ae39a5/manifest") == expected);
}

TEST_CASE("kinds are found by name, others are refused with a similar name", "[cryptomatte][law7]") {
    CHECK(*parse_matte_kind("material", "--cryptomatte") == MatteKind::material);
    const auto wrong = parse_matte_kind("materials", "--cryptomatte");
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().hint == "did you mean 'material'?");
    CHECK(wrong.error().file == "--cryptomatte");
}

}  // namespace
}  // namespace raylex::geoaovs
