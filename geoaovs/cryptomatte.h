// Cryptomatte 1.2.0: layers from which a compositor cuts anti-aliased mattes of named objects, materials or assets.
//
// Source of every fact here: Friedman et al., "Cryptomatte Specification", version 1.2.0 (Psyop/Cryptomatte on GitHub,
// specification/cryptomatte_specification.pdf). A layer set CryptoObject has the planes CryptoObject00.R (id of rank 0)
// .G (its coverage) .B .A (rank 1), CryptoObject01 (ranks 2 and 3), ... ; ids are names hashed by MurmurHash3_x86_32
// and seen as float; header attributes cryptomatte/KEY/{name, hash, conversion, manifest} say so.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/buffer/sinks/ranked_coverage.h"
#include "lpe/result.h"

namespace raylex::geoaovs {

/// MurmurHash3_x86_32 (Appleby 2011, public domain), the specification's hash; of a name's UTF-8 bytes, seed 0.
[[nodiscard]] std::uint32_t murmur_hash3(std::string_view bytes);
/// The bits of the id as a float, "uint32_to_float32": an exponent of all zeros or all ones (denormal, infinity, not a
/// number) has its lowest bit, 23, flipped.
[[nodiscard]] std::uint32_t matte_id(std::string_view name);

/// What a set of mattes tells apart.
enum class MatteKind : std::uint8_t { object, material, asset };
/// "object", "material", "asset", or an Error with the near miss.
Result<MatteKind> parse_matte_kind(std::string_view name, const std::string& where);
/// CryptoObject, CryptoMaterial or CryptoAsset: what the layers' names begin with.
std::string matte_layer(MatteKind kind);

/// What the surfaces of a scene are called, for one kind: `names[of_surface[i]]` is the name of surface number i + 1.
struct MatteNames {
    std::vector<std::string> names;
    std::vector<std::uint32_t> of_surface;
};

class Cryptomatte {
  public:
    static constexpr int default_ranks = 6, most_ranks = 32;
    /// Above this many names the manifest lists those that the image shows.
    static constexpr std::size_t most_manifest_names = 65536;

    /// `ranks` ids are written per pixel: even, 2 to most_ranks. `names` must not be empty strings.
    Cryptomatte(MatteKind kind, int ranks, int width, int height, const MatteNames& names);

    [[nodiscard]] std::string name() const { return matte_layer(kind_); }
    [[nodiscard]] int ranks() const { return ranks_; }
    [[nodiscard]] display::RankedCoverage& coverage() { return coverage_; }
    [[nodiscard]] const display::RankedCoverage& coverage() const { return coverage_; }
    [[nodiscard]] std::size_t name_count() const { return names_.size(); }
    [[nodiscard]] MatteKind kind() const { return kind_; }
    /// In order; with them and the coverage's record the set is made again.
    [[nodiscard]] std::vector<std::string> names() const;
    /// Pairs of names that have one id and so share a matte, for a warning.
    [[nodiscard]] const std::vector<std::pair<std::string, std::string>>& collisions() const { return collisions_; }

    /// Names of the planes, "CryptoObject00.R" ..., and their values in rows [first, end), plane after plane, rows from
    /// the top.
    [[nodiscard]] std::vector<std::string> planes() const;
    [[nodiscard]] std::vector<float> values() const { return values(0, coverage_.height()); }
    [[nodiscard]] std::vector<float> values(int first, int end) const;
    /// Header attributes, the manifest among them.
    [[nodiscard]] std::map<std::string, std::string> attributes() const;

    /// What the ranks written leave out, over the image.
    struct Remainder {
        double largest = 0, mean = 0;  ///< coverage
        std::size_t pixels = 0;        ///< with more than 1e-4
    };
    [[nodiscard]] Remainder remainder() const;

  private:
    [[nodiscard]] std::string manifest() const;
    MatteKind kind_;
    int ranks_;
    std::map<std::string, std::uint32_t> names_;  // name -> id
    std::vector<std::pair<std::string, std::string>> collisions_;
    display::RankedCoverage coverage_;
};

}  // namespace raylex::geoaovs
