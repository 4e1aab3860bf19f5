// Cryptomatte 1.2.0: layers from which a compositor extracts anti-aliased mattes of named objects, materials or assets.
//
// Source of all facts here: Friedman et al., "Cryptomatte Specification", version 1.2.0 (Psyop/Cryptomatte on GitHub,
// specification/cryptomatte_specification.pdf). The layers CryptoObject have the planes CryptoObject00.R (id of rank 0)
// .G (its coverage) .B .A (rank 1), CryptoObject01 (ranks 2 and 3), ... Ids are hashes of names by MurmurHash3_x86_32,
// stored as float; the header attributes cryptomatte/KEY/{name, hash, conversion, manifest} declare this.
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

/// MurmurHash3_x86_32 (Appleby 2011, public domain), the specification's hash, of the UTF-8 bytes of a name with seed
/// 0.
[[nodiscard]] std::uint32_t murmur_hash3(std::string_view bytes);
/// The bits of an id as a float, by the specification's "uint32_to_float32": if the exponent is all zeros or all ones
/// (denormal, infinity, NaN), its lowest bit, 23, is flipped.
[[nodiscard]] std::uint32_t matte_id(std::string_view name);

/// The kind of objects that a set of mattes separates.
enum class MatteKind : std::uint8_t { object, material, asset };
/// Parses "object", "material" or "asset"; an Error suggests a similar word.
Result<MatteKind> parse_matte_kind(std::string_view name, const std::string& where);
/// The prefix of the layers' names: CryptoObject, CryptoMaterial or CryptoAsset.
std::string matte_layer(MatteKind kind);

/// The names of a scene's surfaces for one kind: `names[of_surface[i]]` is the name of surface number i + 1.
struct MatteNames {
    std::vector<std::string> names;
    std::vector<std::uint32_t> of_surface;
};

class Cryptomatte {
  public:
    static constexpr int default_ranks = 6, most_ranks = 32;
    /// If there are more names, the manifest lists only those in the image.
    static constexpr std::size_t most_manifest_names = 65536;

    /// `ranks` ids are written per pixel: an even number, 2 to most_ranks. Names must not be empty.
    Cryptomatte(MatteKind kind, int ranks, int width, int height, const MatteNames& names);

    [[nodiscard]] std::string name() const { return matte_layer(kind_); }
    [[nodiscard]] int ranks() const { return ranks_; }
    [[nodiscard]] display::RankedCoverage& coverage() { return coverage_; }
    [[nodiscard]] const display::RankedCoverage& coverage() const { return coverage_; }
    [[nodiscard]] std::size_t name_count() const { return names_.size(); }
    [[nodiscard]] MatteKind kind() const { return kind_; }
    /// The names in order; with them and the record of the coverage the object can be reconstructed.
    [[nodiscard]] std::vector<std::string> names() const;
    /// Pairs of names with the same id, which therefore share a matte, for a warning.
    [[nodiscard]] const std::vector<std::pair<std::string, std::string>>& collisions() const { return collisions_; }

    /// The names of the planes, "CryptoObject00.R" ... values() returns them for rows [first, end), plane after plane,
    /// rows from the top.
    [[nodiscard]] std::vector<std::string> planes() const;
    [[nodiscard]] std::vector<float> values() const { return values(0, coverage_.height()); }
    [[nodiscard]] std::vector<float> values(int first, int end) const;
    /// Header attributes, including the manifest.
    [[nodiscard]] std::map<std::string, std::string> attributes() const;

    /// The coverage that the written ranks omit, over the image.
    struct Remainder {
        double largest = 0, mean = 0;  ///< coverage
        std::size_t pixels = 0;        ///< pixels with more than 1e-4
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
