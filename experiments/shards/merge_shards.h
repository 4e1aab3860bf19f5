// The render that shards add up to.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer.h"
#include "experiments/shards/shard_render.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct MergedRender {
    display::FrameBuffer frame_buffer;
    std::vector<geoaovs::Cryptomatte> mattes;
    RecordedImage image;  ///< its attributes are those of the first samples' shard, counts being sums
    ShardFacts facts;     ///< sums; the range is the whole
    std::size_t shards = 0;
};

/// Adds the records up, in any order to the same bits. Errors name the file: no record, a damaged one, one of another
/// render (another build, seed, scene or setting: each difference is listed), samples that two have or that none has.
Result<MergedRender> merge_shards(const std::vector<std::string>& records);

/// As one render of all samples writes it: through its display filters, with its mattes.
Status write_merged_image(const std::string& path, const MergedRender& merged);

}  // namespace raylex::experiments
