// The render that shards add up to.
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
    /// Added up when asked for, a band of rows at a time: whatever the number of records, two bands are in memory.
    std::unique_ptr<const display::BandedImage> pixels;
    std::vector<geoaovs::Cryptomatte> mattes;
    RecordedImage image;  ///< its attributes are those of the first samples' shard, counts being sums
    ShardFacts facts;     ///< sums; the range is the whole
    std::size_t shards = 0;
    std::vector<std::pair<unsigned, unsigned>> parts;  ///< which of how many each record was, in their order
    bool has_atlas = false;                            ///< some came with an atlas
};

/// The sum of the records, in any order the same bits. Errors name the file: no record, one that is cut or damaged, one
/// of another build, scene, seed, instruction set or setting (each difference is listed), samples that two have or that
/// none has. Damage to sums is found, and named, when they are asked for.
Result<MergedRender> merge_shards(const std::vector<std::string>& records);

/// As one render of all samples writes it: through its display filters, with its mattes.
Status write_merged_image(const std::string& path, const MergedRender& merged);

}  // namespace raylex::experiments
