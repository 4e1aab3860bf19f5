// Which things cover a pixel, and how much of it each: pairs (id, coverage), ranked. What a cryptomatte is made of.
//
// A thing's coverage is the filter-weighted mean of its visibility: along a camera ray, front to back, each row counts
// by its own opacity times what the rows in front let through, colour by colour, and by the mean of the colours. So the
// coverages of a pixel add up to its alpha as FrameBuffer::resolve_alpha gives it, less what is reported as remainder.
//
// Weights are added as integers in units of 2^-32, so a pixel's record does not depend on which thread, session or
// shard brought a sample, nor in which order (Law 3); each row is off by at most 2^-33. Weights must not be negative:
// kernels with negative lobes cannot be used, see PixelFilter::has_negative_lobes().
//
// Memory: 32 bytes a pixel, and 16 for each id found in it, up to 64 ids; a list has room for at most twice of what it
// holds. When a pixel sees more than 64 ids, those whose mixed id (a fixed bijection) is smallest stay and the others'
// weight goes to the remainder. That is a rule without memory of the order: an id that is ever dropped can never belong
// to the final 64, so the weights of the ids kept are complete.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/buffer/sample_sink.h"
#include "lpe/result.h"

namespace raylex::display {

class RankedCoverage final : public SampleSink {
  public:
    static constexpr std::size_t ids_per_pixel = 64;

    struct Entry {
        std::uint32_t id = 0;      ///< never 0
        std::uint64_t weight = 0;  ///< in units of 2^-32
    };
    /// A pixel's whole record: what restore() takes.
    struct Record {
        std::uint64_t weight = 0;        ///< of all samples
        std::uint64_t remainder = 0;     ///< of what has opacity and neither id nor place
        std::span<const Entry> entries;  ///< in order of their mixed ids
    };

    /// `ids[surface]` for SampleTable::surface; ids[0], and every id that is 0, stands for nothing that has a name.
    RankedCoverage(int width, int height, std::vector<std::uint32_t> ids);

    void accumulate(const SampleTable& table) override;
    [[nodiscard]] std::size_t expected_bytes() const override { return expected_bytes(width_, height_); }
    /// A list per pixel with room for two ids.
    [[nodiscard]] static std::size_t expected_bytes(int width, int height) {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * (sizeof(Pixel) + 2 * sizeof(Entry));
    }
    /// One sample's share of one pixel, for renderers without a sample table: `visibility` in [0, 1]. Every sample also
    /// needs one add_weight().
    void add(std::size_t pixel, std::uint32_t id, double filter_weight, double visibility);
    void add_weight(std::size_t pixel, double filter_weight);
    /// Adds what another buffer of the same size holds; exact, in any order.
    Status merge(const RankedCoverage& other);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] Record record(std::size_t pixel) const;
    void restore(std::size_t pixel, const Record& record);
    /// All pixels as bytes, appended; and back, into a buffer of the same size. On error this buffer may hold part of
    /// it.
    void append_record(std::string& bytes) const;
    Status restore_record(std::string_view bytes);
    [[nodiscard]] std::size_t memory_bytes() const;

    struct Rank {
        std::uint32_t id = 0;  ///< 0: this rank is empty
        double coverage = 0;
    };
    /// The `ranks.size()` ids that cover most of the pixel, the most first and equals by id. Returns the remainder: the
    /// coverage of everything else that has opacity.
    double resolve(std::size_t pixel, std::span<Rank> ranks) const;
    /// Calls visit(id) for every id that any pixel holds; ids may come more than once.
    void for_each_id(const std::function<void(std::uint32_t)>& visit) const;

  private:
    struct Pixel {
        std::uint64_t weight = 0, remainder = 0;
        std::unique_ptr<Entry[]> entries;
        std::uint32_t count = 0, capacity = 0;
    };
    static void add_to(Pixel& pixel, std::uint32_t id, std::uint64_t weight);

    int width_, height_;
    std::vector<std::uint32_t> ids_;
    std::vector<Pixel> pixels_;
};

}  // namespace raylex::display
