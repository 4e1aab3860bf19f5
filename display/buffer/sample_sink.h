// Receivers of finished samples other than the frame buffer: deep images, custom statistics.
#pragma once

#include <cstddef>
#include <span>

#include "display/services/samples/sample_table.h"

namespace raylex::display {

class SampleSink {
  public:
    virtual ~SampleSink() = default;
    /// Takes one batch after the sample filters; discarded batches are never passed. Threads call it concurrently, but
    /// never for the same pixel. Batches arrive in any order, and the content of a sink must not depend on it (Law 3).
    virtual void accumulate(const SampleTable& table) = 0;
    /// Takes raster splats, as FrameBuffer::splat() does. Threads call it concurrently for different pixels.
    virtual void splat(const SampleTable& /*table*/, std::span<const int> /*rows*/) {}
    /// Called between two phases of a render, while no thread adds samples. The content then does not depend on
    /// threads.
    virtual void end_phase() {}
    /// Returns whether end_phase() must be called after every block of samples of the image.
    [[nodiscard]] virtual bool wants_phases() const { return false; }
    /// Returns whether it reads the values of channels. If not, light may reach channels as sums of many samples.
    [[nodiscard]] virtual bool reads_channels() const { return true; }
    /// Estimated bytes at the end of the render, for the table that is printed before it starts.
    [[nodiscard]] virtual std::size_t expected_bytes() const = 0;
};

}  // namespace raylex::display
