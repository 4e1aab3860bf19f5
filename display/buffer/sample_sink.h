// What takes in finished samples beside the frame buffer: deep images, statistics of one's own.
#pragma once

#include <cstddef>

#include "display/services/sample_table.h"

namespace raylex::display {

class SampleSink {
  public:
    virtual ~SampleSink() = default;
    /// One batch, after the sample filters; never one that was discarded. Threads call at once, but never two of them
    /// for the same pixel. Batches come in any order: what a sink keeps must not depend on it (Law 3).
    virtual void accumulate(const SampleTable& table) = 0;
    /// An estimate of what it will have taken when the render ends, for the table printed before it begins.
    [[nodiscard]] virtual std::size_t expected_bytes() const = 0;
};

}  // namespace raylex::display
