// How each kind of channel is stored in an OpenEXR file: one documented table, which a job may override.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "display/output/image_types.h"
#include "display/services/channel.h"
#include "display/services/parameters.h"

namespace raylex::display {

/// What a channel holds, as far as storage is concerned.
///
///   kind      channels                                      stored by default   may be half
///   light     beauty and light path expressions             float zip           yes
///   color     other R G B, such as albedo                   float zip           yes
///   normal    unit vectors                                  float zip           yes
///   position  points and vectors: P, Pw, st, dPdu           float zip           no: a half has 11 bits
///   value     single numbers: z, VLen, time; variances      float zip           no
///   id        integers                                      uint zips           no: not a number to round
///
/// Light is float because Law 1 is about the bits in the file: with half layers a split holds to 2^-10 only. Zip packs
/// 16 lines at a time, zips one (quicker for readers that want single lines), piz suits noisy half, rle is quick and
/// large. dwaa (32 lines at a time) and dwab (256) lose what is hardly seen, the more the higher the level behind a
/// colon: for light and color alone, whose splits then hold within what the compression does (`raylex verify`), in
/// parts of their own. pxr24, b44 and b44a lose bits of float data too and are refused.
enum class ChannelKind : std::uint8_t { light, color, normal, position, value, id };
inline constexpr std::size_t channel_kind_count = 6;

enum class ExrCompression : std::uint8_t { none, rle, zips, zip, piz, dwaa, dwab };

[[nodiscard]] inline bool is_lossy(ExrCompression compression) {
    return compression == ExrCompression::dwaa || compression == ExrCompression::dwab;
}

struct ExrStorage {
    StoredType type = StoredType::single_float;
    ExrCompression compression = ExrCompression::zip;
    float level = 45;  ///< of dwaa and dwab; 45 is OpenEXR's own, and "visually lossless"
    bool operator==(const ExrStorage&) const = default;
};

using ExrStorageTable = std::array<ExrStorage, channel_kind_count>;

[[nodiscard]] ExrStorageTable default_exr_storage();
[[nodiscard]] ChannelKind kind_of(const ChannelDefinition& channel);
[[nodiscard]] const char* kind_name(ChannelKind kind);
/// "float zip", "half dwaa:45", as it stands in a header or a job.
[[nodiscard]] std::string storage_text(const ExrStorage& storage);

/// "half piz", "zips" or "half", words in any order, changes one row of the table; `kind` is a row's name or "all"
/// (which changes the type and a lossy compression only where the kind allows it). Errors at `where`: an unknown kind
/// or word (with near misses); a type or a lossy compression that the kind does not allow.
Status override_exr_storage(ExrStorageTable& table, const std::string& kind, const std::string& text,
                            const SourceLocation& where);

/// The id of a colour space by the Color Interop Forum, "lin_rec709_scene" (ASWF Color Interop Forum, "Color Space
/// Encodings for Texture Assets and CG Rendering", 2024), or "unknown" for primaries that have none.
[[nodiscard]] std::string color_interop_id(const Chromaticities& primaries);

}  // namespace raylex::display
