// Renders an image that is larger than memory in buckets, which are bands of its rows. Private to transport/render.
//
// A bucket is rendered like a crop: its pixels get the bits that they have in the whole image. When it is finished, its
// record is saved, as a checkpoint of a finished render, to a file of its own in the folder of CheckpointSettings; then
// its memory is released. So a render that was killed continues with the missing buckets, whatever their size, and
// within a bucket that was saved before it was finished. Writers and viewers read the image from the files, band by
// band (display/buffer/frame_buffer/banded_image.h).
//
// Buckets refuse features in which a bucket's pixels depend on others: integrators that splat anywhere or that learn
// from the whole image, filter mode splat, adaptive sampling, and limits of time or error. They also refuse outputs
// that are stored as a whole: deep images, path atlases, cryptomattes.
//
// Memory: a bucket is stored once while it is rendered; while it is saved or read, its packed bytes are added. The
// scene's memory is measured before buckets are planned, and the memory for writing the image is estimated.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "transport/render/clock.h"
#include "transport/render/stages/prepared_job.h"

namespace raylex::transport {

struct BucketPlan {
    std::vector<display::RowRange> buckets;
    std::string folder;

    [[nodiscard]] std::string file_of(const display::RowRange& rows) const;
};

/// Returns nothing if the image is rendered as a whole: because buckets are not requested, or because the image fits.
/// Errors name what cannot be rendered in buckets, or report that not even a row fits.
Result<std::optional<BucketPlan>> plan_buckets(const PreparedJob& prepared);

/// Renders bucket after bucket.
Result<RenderOutput> render_buckets(PreparedJob& prepared, const BucketPlan& plan, const Stopwatch& since_call,
                                    const std::function<void(const RenderProgress&)>& progress,
                                    const std::atomic<bool>* stop);

}  // namespace raylex::transport
