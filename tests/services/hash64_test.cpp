// XXH64 against the values of its specification and its reference implementation.
#include <catch2/catch.hpp>

#include <string>

#include "display/services/hash64.h"

TEST_CASE("the hash is XXH64", "[hash]") {
    using raylex::hash64;
    // Published test values: the empty text, and short and long texts with seed 0.
    CHECK(hash64("") == 0xef46db3751d8e999ull);
    CHECK(hash64("a") == 0xd24ec4f1a98c6e5bull);
    CHECK(hash64("abc") == 0x44bc2cf5ad770999ull);
    CHECK(hash64("Nobody inspects the spammish repetition") == 0xfbcea83c8a378bf1ull);
    CHECK(raylex::hash_text(hash64("abc")) == "44bc2cf5ad770999");
    CHECK(raylex::hash_text(1) == "0000000000000001");
}

TEST_CASE("every byte and the seed affect the hash, at every length", "[hash]") {
    std::string text;
    for (int length = 0; length < 100; ++length) {
        const std::uint64_t hash = raylex::hash64(text);
        CHECK(raylex::hash64(text, 1) != hash);
        for (char& c : text) {
            c = static_cast<char>(c ^ 1);
            CHECK(raylex::hash64(text) != hash);
            c = static_cast<char>(c ^ 1);
        }
        text += static_cast<char>(length * 37);
    }
}
