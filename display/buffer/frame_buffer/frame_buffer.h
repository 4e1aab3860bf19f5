// The frame buffer and its record.
//
// Canonical summation. Double arithmetic sums the samples of a pixel in sample order over aligned blocks of
// `block_size` samples (light of channels that sets of a SampleTable represent: in the order of contribution). Each
// block sum is then added exactly, in 128-bit fixed point with quantum 2^quantum_exponent. Integer addition is
// associative, so the sum does not depend on the thread, session or shard of a block, or on the order of blocks (Law
// 3). The default quantum is 2^-80: below 1e-12 relative to a pixel of 1e-12 (Law 1), with room for sums up to 2^47. A
// channel with values of the order of 2^scale_exponent shifts both by that factor. A block sum out of range is rejected
// and counted like a non-finite value, never wrapped.
//
// The pixel filter has two modes. Importance mode (the default): samples are distributed according to the kernel; each
// belongs to one pixel and has the weight CameraRow::filter_weight. Splat mode (create() gets the kernel): samples are
// distributed evenly over the image and over a border as wide as the kernel's reach; a sample counts, weighted by the
// kernel, for every pixel within reach of its CameraRow::screen_x and screen_y. Each block of samples is added to each
// such pixel as one exact addition. Neighbouring pixels then share samples, so the scatter of a pixel's samples does
// not give its error: statistics are refused. Rules other than `filter` use the pixel's own samples in both modes.
//
// Raster splats are light that a path brings to an arbitrary raster position (from a light tracer, a Markov chain).
// create() gets the kernel that weights them for the pixels in reach. A filtered pixel of an expression channel then is
//     value of its camera samples, in either mode + sum(kernel x value) / light paths per pixel,
// where the kernel has integral 1 and count_light_paths() counts the light paths. Each splat is one exact addition per
// pixel, so the order of splats is irrelevant (Law 3). A light path can reach a pixel several times or never, so the
// scatter of a pixel's splats does not give its error without the paths that missed the pixel. So moments are those of
// camera samples alone, and half buffers are refused.
// How a rule combines a channel's samples:
//   filter     sum of weight x value over the sum of weights, both kept exactly (weight: CameraRow::filter_weight)
//   average    mean of the written rows, unweighted
//   sum        sum of the written rows, unweighted (an expression channel: all rows)
//   min, max   per component, over the written rows
//   zmin, zmax the value of the written row with the smallest / largest SampleTable::depth; ties go to the smallest
//              sample index, within a sample to the first row
// Every row of an expression channel counts as written. A pixel without written rows has the miss value; in a kernel
// misses count as samples with the miss value (0 if it is not finite).
//
// Extra rows (AddSample: surfaces and volumes behind one another) belong to the sample of their camera ray:
//   rules      use every row, so that zmin picks the nearest written surface
//   filter     splatted values of a sample's rows add up; written ones count as ray_rows.h defines
//   alpha      1 - (1 - o_1)(1 - o_2)... per colour over the sample's rows, then the mean of the colours
//
// Layers of statistics (ChannelDefinition::statistic) are computed from sums of their source: moments for variance and
// mse, two more sums for even and odd. Samples of even and odd index are independent if sample numbers are. Scrambled
// Sobol' points balance each other, so the two halves differ by more than the error of the whole.
//
// Memory: 48 bytes per pixel of an rgb channel, 144 with moments, 96 more with half buffers. The system provides zero
// pages, so pixels without contributions cost only address space.
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

/// Splat mode: the distance in pixels at which a sample can still count, for a kernel of this radius.
[[nodiscard]] int splat_reach(float radius);

class FrameBuffer final : public PixelImage {
  public:
    /// Throws std::bad_alloc if the system refuses the address space; create() returns an error instead. `splat` is the
    /// kernel of splat mode, null for importance mode. `raster` is the kernel of raster splats, null for none. Both are
    /// copied.
    FrameBuffer(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                const PixelFilter* splat = nullptr, const PixelFilter* raster = nullptr);
    ~FrameBuffer() override;
    FrameBuffer(FrameBuffer&&) noexcept;
    FrameBuffer& operator=(FrameBuffer&&) noexcept;

    /// Creates a frame buffer. Errors: an invalid layout, statistics that the mode does not support, not enough memory.
    static Result<FrameBuffer> create(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                                      const PixelFilter* splat = nullptr, const PixelFilter* raster = nullptr);

    /// [channel] 1 for channels that keep only the weighted sum of each block; sets of a SampleTable can represent
    /// them.
    [[nodiscard]] std::vector<std::uint8_t> sums_only() const;
    /// Prepares for tables with these sets, whose block size is that of this buffer, so that accumulate() need not
    /// visit the channels of the sets one by one.
    void expect(const SplatSets& sets);

    /// Adds one batch. Consecutive rows of one pixel must be in ascending sample order and form whole aligned blocks,
    /// except for the last block of the budget. The sets of the table must have this block size; otherwise the batch is
    /// rejected. Threads can call this concurrently for different pixels; in splat mode, for pixels that are farther
    /// apart than twice splat_reach().
    void accumulate(const SampleTable& table);

    /// Adds raster splats: for every row in `rows` the values of its expression channels, times
    /// CameraRow::filter_weight, weighted by the kernel around CameraRow::screen_x and screen_y. Threads can call this
    /// concurrently for different pixels. Requires a raster kernel.
    void splat(const SampleTable& table, std::span<const int> rows);
    /// Adds to the number of light paths, including paths without splats. Any thread, at any time.
    void count_light_paths(std::uint64_t paths);
    [[nodiscard]] std::uint64_t light_path_count() const;
    [[nodiscard]] bool takes_raster_splats() const;

    /// Adds the record of another buffer with equal layout and channels: exactly, in any order (Law 3). The two must
    /// have disjoint samples in whole blocks. An error leaves this buffer unchanged.
    Status merge(const FrameBuffer& other);

    /// Appends the whole record: layout, channels, every plane. from_record() reads it. Shards, checkpoints and
    /// experiment cells use this format. Do not call it while samples are being added.
    void append_record(std::string& bytes) const;
    /// Appends the record of rows [first, end) of this buffer: the record of a frame buffer of that band, with
    /// layout().first_row.
    void append_record(std::string& bytes, int first, int end) const;
    /// Reads a record of append_record() and returns a bit-identical frame buffer. An Error if the bytes are not a
    /// record of this version or end early; the surrounding file (checkpoint/) detects damage. A record contains only
    /// the names of kernels, so a buffer that will get more samples needs adopt_kernels().
    static Result<FrameBuffer> from_record(std::string_view bytes);
    /// An empty buffer of another size, with the channels and modes of this one.
    [[nodiscard]] Result<FrameBuffer> like(const FrameBufferLayout& layout) const;
    /// Replaces the rows of a band of this image, and adds its counts of rejected sums. An Error if it is not such a
    /// band.
    Status place(const FrameBuffer& band);
    /// After from_record(): takes the kernels from a buffer with equal layout and channels.
    void adopt_kernels(const FrameBuffer& other);

    /// The first difference in layout or channels, or empty; merge() requires that there is none.
    [[nodiscard]] std::string difference_from(const FrameBuffer& other) const;

    [[nodiscard]] const FrameBufferLayout& layout() const override;
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override;
    [[nodiscard]] std::uint64_t sample_count(int x, int y) const;
    [[nodiscard]] std::uint64_t rejected_count() const;              ///< block sums out of range or not finite, over
                                                                     ///< all channels
    [[nodiscard]] std::uint64_t rejected_count(ChannelId id) const;  ///< for one channel
    /// For filters with negative weights that can cancel: the largest magnitude of light whose difference can be a
    /// pixel's mean; otherwise 0. Sums of layers can deviate by the double rounding of this magnitude.
    [[nodiscard]] double light_magnitude() const;

    using PixelImage::resolve;
    using PixelImage::resolve_alpha;
    /// The pixels of a channel: the filtered value, or the result of its rule. No sample can be added to the region's
    /// pixels meanwhile; other pixels are free.
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override;
    /// Coverage: the filtered mean of the samples' opacity.
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override;
    /// Variance of the pixel mean (Statistic::mse) for a channel that keeps moments, even without a layer of
    /// statistics; empty if it keeps none, 0 for pixels with fewer than two samples. With weights w and mean m:
    ///     sum(w^2) sum((v - m)^2) / ((n - 1) sum(w)^2),
    /// which equals sample variance / n for unit weights and is exact for weights of equal size and either sign.
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(ChannelId id) const;
    /// Variance of the pixel mean in a region. No sample can be added to the region's pixels meanwhile.
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
