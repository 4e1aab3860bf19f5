// What takes in finished samples beside the frame buffer: deep images, statistics of one's own.
#pragma once

#include <cstddef>
#include <span>

#include "display/services/samples/sample_table.h"

namespace raylex::display {

class SampleSink {
  public:
    virtual ~SampleSink() = default;
    /// One batch, after the sample filters; never one that was discarded. Threads call at once, but never two of them
    /// for the same pixel. Batches come in any order: what a sink keeps must not depend on it (Law 3).
    virtual void accumulate(const SampleTable& table) = 0;
    /// Raster splats, as FrameBuffer::splat takes them in. Threads call at once for different pixels.
    virtual void splat(const SampleTable& /*table*/, std::span<const int> /*rows*/) {}
    /// Between two phases of a render, when no thread brings samples: what is there by then depends on no thread.
    virtual void end_phase() {}
    /// Whether it has to be told so after every block of samples of the image.
    [[nodiscard]] virtual bool wants_phases() const { return false; }
    /// Whether it looks at what channels hold: else light may reach them by sums of many samples.
    [[nodiscard]] virtual bool reads_channels() const { return true; }
    /// An estimate of what it will have taken when the render ends, for the table printed before it begins.
    [[nodiscard]] virtual std::size_t expected_bytes() const = 0;
};

}  // namespace raylex::display
