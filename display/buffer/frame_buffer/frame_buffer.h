// The frame buffer and its one canonical record.
//
// Canonical summation. The samples of a pixel are summed in double, in sample order (light of channels that sets of a
// SampleTable stand for: in the order that it was contributed in), over aligned blocks of
// `block_size` samples; each block sum is then added exactly, in 128-bit fixed point with quantum 2^quantum_exponent.
// Integer addition is associative, so the sum does not depend on which thread, session or shard brought a block, nor in
// which order (Law 3). The quantum is 2^-80 by default: relative to a pixel of 1e-12 still below 1e-12 (Law 1), with
// room for sums up to 2^47; a channel whose values are of the order of 2^scale_exponent has both that much higher.
// A block sum out of range is rejected and counted like a non-finite value, never wrapped.
//
// Two modes of the pixel filter. Importance mode (the usual one): samples are drawn as the kernel says, each belongs to
// one pixel and counts by CameraRow::filter_weight. Splat mode (create() is given the kernel): samples are drawn
// evenly, in the image and as far around it as the kernel reaches, and count by the kernel for every pixel in reach of
// their CameraRow::screen_x and screen_y. Each block of samples goes to each such pixel as one exact addition.
// Neighbouring pixels then share samples, so a pixel's own scatter says nothing of its error: statistics are refused.
// Rules other than `filter` take the samples of the pixel itself in both modes.
//
// Raster splats: light that a path brings to a raster position of its own (a light tracer's, a Markov chain's).
// create() is given the kernel by which it counts for the pixels in reach; a pixel of an expression channel that is
// filtered then is
//     what its camera samples come to, by either mode + sum(kernel x value) / light paths a pixel,
// the kernel being of integral 1 and the light paths those that count_light_paths() was told. Each splat goes to each
// pixel in one exact addition, so splats have no order at all (Law 3). A light path may reach a pixel more than once or
// never: what one pixel's splats scatter by says nothing of its error without the paths that missed it, so moments are
// of camera samples alone, and halves are refused.
//
// What a channel's samples become:
//   filter     sum of weight x value over the sum of weights, both kept exactly (weight: CameraRow::filter_weight)
//   average    mean of the rows that were written, unweighted
//   sum        sum of the rows that were written, unweighted (an expression channel: all rows)
//   min, max   per component, over the rows that were written
//   zmin, zmax the value of the written row with the smallest / largest SampleTable::depth; among equals the one with
//              the smallest sample index, within a sample the first row
// Every row of an expression channel counts as written. A pixel to which no row was written has the miss value, but a
// kernel counts misses as samples with the miss value (0 when that is not finite).
//
// Extra rows (AddSample: surfaces and volumes behind one another) belong to the sample of their camera ray:
//   rules      see every row, so that zmin takes the nearest written surface
//   filter     splatted values of a sample's rows add up; written ones count as ray_rows.h defines
//   alpha      1 - (1 - o_1)(1 - o_2)... per colour over the sample's rows, then the mean of the colours
//
// Layers of statistics (ChannelDefinition::statistic) are resolved from what their source keeps: moments for variance
// and mse, two more sums for even and odd. Samples of even and of odd index are independent where sample numbers are;
// with scrambled Sobol' points they balance each other, so the two halves differ by more than the whole is off.
//
// Memory: 48 bytes per pixel of an rgb channel, 144 with moments, 96 more with half buffers, taken from the system as
// zero pages, so what no contribution reaches costs address space only.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/services/channel.h"
#include "display/services/samples/sample_table.h"
#include "lpe/result.h"

namespace raylex::display {

class PixelFilter;

/// In splat mode: how many pixels away a sample can still count under a kernel of this radius.
[[nodiscard]] int splat_reach(float radius);

class FrameBuffer final : public PixelImage {
  public:
    /// Throws std::bad_alloc when the system refuses the address space; create() is the checked door.
    /// `splat`, the kernel of splat mode, is copied; null for importance mode. So is `raster`, the kernel of raster
    /// splats; null when there will be none.
    FrameBuffer(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                const PixelFilter* splat = nullptr, const PixelFilter* raster = nullptr);
    ~FrameBuffer() override;
    FrameBuffer(FrameBuffer&&) noexcept;
    FrameBuffer& operator=(FrameBuffer&&) noexcept;

    /// A frame buffer, or an error: a layout that makes no sense, statistics that the mode does not allow, or not
    /// enough memory.
    static Result<FrameBuffer> create(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                                      const PixelFilter* splat = nullptr, const PixelFilter* raster = nullptr);

    /// [channel] 1 for those of whose samples only the weighted sum of a block is kept: sets of a SampleTable may stand
    /// for them.
    [[nodiscard]] std::vector<std::uint8_t> sums_only() const;
    /// Announces the sets of the tables to come, of this buffer's block size, so that their channels are not looked
    /// through one by one.
    void expect(const SplatSets& sets);

    /// Takes in one batch: rows of one pixel that stand together must be in ascending sample order and whole aligned
    /// blocks, but for the last of the budget. Sets of the table must be of this block size: a batch with others is
    /// rejected. Threads may call at once for different pixels; in splat mode, for pixels farther apart than twice
    /// splat_reach().
    void accumulate(const SampleTable& table);

    /// Takes in raster splats: of every row in `rows`, what its expression channels hold, times
    /// CameraRow::filter_weight and the kernel about CameraRow::screen_x and screen_y. Threads may call at once for
    /// different pixels. Needs a raster kernel.
    void splat(const SampleTable& table, std::span<const int> rows);
    /// That many more light paths are in, whether or not they splatted anything. Any thread, any time.
    void count_light_paths(std::uint64_t paths);
    [[nodiscard]] std::uint64_t light_path_count() const;
    [[nodiscard]] bool takes_raster_splats() const;

    /// Adds the record of another buffer of the same layout and channels: exact, in any order (Law 3). The samples of
    /// the two must be disjoint and whole blocks. On error this buffer is unchanged.
    Status merge(const FrameBuffer& other);

    /// The whole record as bytes, appended to `bytes`: layout, channels, every plane. What from_record() takes; shards,
    /// checkpoints and experiment cells are this. Not while samples are being added.
    void append_record(std::string& bytes) const;
    /// The same of rows [first, end) alone, counted in this buffer: the record of a frame buffer of that band, with
    /// layout().first_row.
    void append_record(std::string& bytes, int first, int end) const;
    /// The frame buffer that append_record() was called on: the same bits in every respect. An Error when the bytes are
    /// no record of this version or end too early; damage within is for the file around them to find (checkpoint/). The
    /// kernels of splat mode and raster splats are there by name only: what is to take in samples again adopts them.
    static Result<FrameBuffer> from_record(std::string_view bytes);
    /// An empty one of another size, with this one's channels and ways of taking samples in.
    [[nodiscard]] Result<FrameBuffer> like(const FrameBufferLayout& layout) const;
    /// Puts a band of this image where it belongs, in place of what is there; counts of refused sums are added up. An
    /// Error when it is none.
    Status place(const FrameBuffer& band);
    /// After from_record(): the kernels of a buffer from which this one does not differ.
    void adopt_kernels(const FrameBuffer& other);

    /// What of layout and channels is not the same, or empty: merge() takes equals only.
    [[nodiscard]] std::string difference_from(const FrameBuffer& other) const;

    [[nodiscard]] const FrameBufferLayout& layout() const override;
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override;
    [[nodiscard]] std::uint64_t sample_count(int x, int y) const;
    [[nodiscard]] std::uint64_t rejected_count() const;              ///< block sums out of range or not finite, in all
    [[nodiscard]] std::uint64_t rejected_count(ChannelId id) const;  ///< of one channel
    /// The largest magnitude of light that a pixel's mean can be the difference of, where filter weights may be
    /// negative and cancel; 0 where they are not. A double's rounding of that is what sums of layers may be off by.
    [[nodiscard]] double light_magnitude() const;

    using PixelImage::resolve;
    using PixelImage::resolve_alpha;
    /// The pixels of a channel: filtered value, or what its rule picks. The region's pixels must not be added to
    /// meanwhile; others may.
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override;
    /// Coverage: filtered mean of the samples' opacity.
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override;
    /// Variance of the pixel mean (Statistic::mse) of a channel that keeps moments, whether or not it has a layer;
    /// empty when it keeps none, 0 for pixels with fewer than two samples. With weights w and mean m:
    ///     sum(w^2) sum((v - m)^2) / ((n - 1) sum(w)^2),
    /// which is sample variance / n for unit weights and exact for weights of one size and either sign.
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(ChannelId id) const;
    /// Of a part; its pixels must not be added to meanwhile.
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(ChannelId id, const PixelRegion& region) const;

  private:
    struct Storage;
    struct Run;
    struct Channel;
    static Result<FrameBuffer> of_kernels_by_name(const FrameBufferLayout& layout,
                                                  std::span<const ChannelDefinition> channels,
                                                  const std::string& kernel, const std::string& raster_kernel);
    void accumulate_run(const SampleTable& table, const Run& run);
    void accumulate_channels(const SampleTable& table, const Run& run);
    std::unique_ptr<Storage> storage_;
};

}  // namespace raylex::display
