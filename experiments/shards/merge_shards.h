// Merges the shards of a render.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "display/buffer/frame_buffer/banded_image.h"
#include "experiments/shards/shard_render.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct MergedRender {
    /// The merged pixels. They are summed on demand, one band of rows at a time, so only two bands are in memory for
    /// any number of records.
    std::unique_ptr<const display::BandedImage> pixels;
    std::vector<geoaovs::Cryptomatte> mattes;
    RecordedImage image;  ///< attributes of the shard with the first samples; counts are sums
    ShardFacts facts;     ///< sums over the shards; the range is all samples
    std::size_t shards = 0;
    std::vector<std::pair<unsigned, unsigned>> parts;  ///< part and number of parts of each record
    bool has_atlas = false;                            ///< some shards have an atlas
};

/// Merges the records; their order does not change the bits. Errors name the file: not a record; a truncated or damaged
/// record; a record of another build, scene, seed, instruction set or setting, with all differences; duplicate or
/// missing samples. Damage to the sums is found, and reported, when they are read.
Result<MergedRender> merge_shards(const std::vector<std::string>& records);

/// Writes the file that a single render of all samples would write, with display filters and cryptomattes.
Status write_merged_image(const std::string& path, const MergedRender& merged);

}  // namespace raylex::experiments
