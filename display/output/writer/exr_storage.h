// The storage of each kind of channel in an OpenEXR file: a documented table that a job can override.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "display/output/image_types.h"
#include "display/services/channel.h"
#include "display/services/parameters.h"

namespace raylex::display {

/// The content of a channel with regard to storage.
///
///   kind      channels                                      default storage     may be half
///   light     beauty and light path expressions             float zip           yes
///   color     other R G B, such as albedo                   float zip           yes
///   normal    unit vectors                                  float zip           yes
///   position  points and vectors: P, Pw, st, dPdu           float zip           no: a half has 11 bits
///   value     single numbers: z, VLen, time; statistics;    float zip           no
///             cryptomattes
///   id        integers                                      uint zips           no: not a number to round
///
/// Light is float because Law 1 applies to the bits in the file: with half layers a split holds only to 2^-10. Zip
/// packs 16 lines at a time, zips one (faster for readers of single lines), piz suits noisy half, rle is fast and
/// large. dwaa (32 lines at a time) and dwab (256) lose details that are hardly visible, more at a higher level (after
/// a colon). They are permitted for light and color only, in parts of their own; `raylex verify` takes their measured
/// loss into account. pxr24, b44 and b44a also lose bits of float data, and are refused.
enum class ChannelKind : std::uint8_t { light, color, normal, position, value, id };
inline constexpr std::size_t channel_kind_count = 6;

enum class ExrCompression : std::uint8_t { none, rle, zips, zip, piz, dwaa, dwab };

[[nodiscard]] inline bool is_lossy(ExrCompression compression) {
    return compression == ExrCompression::dwaa || compression == ExrCompression::dwab;
}

struct ExrStorage {
    StoredType type = StoredType::single_float;
    ExrCompression compression = ExrCompression::zip;
    float level = 45;  ///< of dwaa and dwab; 45 is OpenEXR's default, described as "visually lossless"
    bool operator==(const ExrStorage&) const = default;
};

using ExrStorageTable = std::array<ExrStorage, channel_kind_count>;

[[nodiscard]] ExrStorageTable default_exr_storage();

/// Storage for the programs that will read the file: what a preset changes in the default table, as kind and text of
/// override_exr_storage().
struct ExrPreset {
    const char* name;
    std::vector<std::pair<const char*, const char*>> changes;
};
/// nuke, blender and archive.
[[nodiscard]] const std::vector<ExrPreset>& exr_presets();
/// Replaces the whole table by that of a preset. Errors, at `where`: an unknown name (with a similar one).
Status use_exr_preset(ExrStorageTable& table, const std::string& name, const SourceLocation& where);
[[nodiscard]] ChannelKind kind_of(const ChannelDefinition& channel);
[[nodiscard]] const char* kind_name(ChannelKind kind);
/// The text "float zip" or "half dwaa:45", as in headers and jobs.
[[nodiscard]] std::string storage_text(const ExrStorage& storage);

/// Changes one row of the table. `text` is "half piz", "zips" or "half", with words in any order; `kind` is the name of
/// a row, or "all", which changes the type and a lossy compression only where the kind permits it. Errors, at `where`:
/// an unknown kind or word (with similar ones); a type or a lossy compression that the kind does not permit.
Status override_exr_storage(ExrStorageTable& table, const std::string& kind, const std::string& text,
                            const SourceLocation& where);

/// The id of a colour space of the Color Interop Forum, such as "lin_rec709_scene" (ASWF Color Interop Forum, "Color
/// Space Encodings for Texture Assets and CG Rendering", 2024), or "unknown" for primaries without an id.
[[nodiscard]] std::string color_interop_id(const Chromaticities& primaries);

}  // namespace raylex::display
