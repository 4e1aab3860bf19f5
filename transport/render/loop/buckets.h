// Rendering an image that is larger than memory: a bucket, a band of its rows, after another. Private to
// transport/render.
//
// A bucket is rendered like a crop: its pixels get the bits that they have in the whole image. Once it is finished its
// record is saved, as a checkpoint that has all there is to do, in a file of its own in the folder that
// CheckpointSettings name; then its memory is given back. So a render that was killed goes on with the buckets that are
// not there, whatever their size, and amid a bucket that was saved on the way. The image is read from the files, band
// by band (display/buffer/frame_buffer/banded_image.h), by whoever writes or shows it.
//
// Refused, since a bucket's pixels would need others: integrators whose light lands anywhere or that learn from the
// whole image, filter mode splat, adaptive sampling and ends by time or error; and, since they are kept as a whole:
// deep images, path atlases, cryptomattes.
//
// Memory: while it is rendered a bucket is there once, while it is saved or read its packed bytes come on top. What the
// scene takes is measured before buckets are planned, what writing the image takes is estimated.
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

/// None when the image is rendered as a whole: nothing else is asked for, or it fits. An Error says what cannot be
/// rendered in buckets, or that a row does not fit.
Result<std::optional<BucketPlan>> plan_buckets(const PreparedJob& prepared);

/// Moves the job from bucket to bucket.
Result<RenderOutput> render_buckets(PreparedJob& prepared, const BucketPlan& plan, const Stopwatch& since_call,
                                    const std::function<void(const RenderProgress&)>& progress,
                                    const std::atomic<bool>* stop);

}  // namespace raylex::transport
