// The objects that cover a pixel and their coverages: pairs (id, coverage), ranked. Cryptomattes are made from it.
//
// The coverage of an object is the filter-weighted mean of its visibility. Along a camera ray, front to back, the
// visibility of each row is its opacity times the transmittance of the rows in front of it, per colour, averaged over
// the colours. So the coverages of a pixel add up to its alpha (FrameBuffer::resolve_alpha) minus the remainder.
//
// Weights are added as integers in units of 2^-32, so the record of a pixel does not depend on the thread, session or
// shard of a sample, or on the order (Law 3). Each row has an error of at most 2^-33. Weights must not be negative, so
// kernels with negative lobes cannot be used (PixelFilter::has_negative_lobes()).
//
// Memory: 32 bytes per pixel, plus 16 for each of its ids, up to 64 ids; the capacity of a list is at most twice its
// size. If a pixel sees more than 64 ids, those with the smallest mixed id (a fixed bijection) stay, and the weight of
// the others goes to the remainder. This rule does not depend on the order: a dropped id can never be among the final
// 64, so the weights of the kept ids are complete.
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
    /// The whole record of a pixel, as restore() takes it.
    struct Record {
        std::uint64_t weight = 0;        ///< weight of all samples
        std::uint64_t remainder = 0;     ///< weight of surfaces that have opacity but no id, or no room in the list
        std::span<const Entry> entries;  ///< sorted by mixed id
    };

    /// `ids` is indexed by SampleTable::surface; ids[0] and every id of 0 mean a surface without a name.
    RankedCoverage(int width, int height, std::vector<std::uint32_t> ids);

    void accumulate(const SampleTable& table) override;
    [[nodiscard]] std::size_t expected_bytes() const override { return expected_bytes(width_, height_); }
    /// Estimates one list with room for two ids per pixel.
    [[nodiscard]] static std::size_t expected_bytes(int width, int height) {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * (sizeof(Pixel) + 2 * sizeof(Entry));
    }
    /// Adds the coverage of one sample to one pixel, for renderers without a sample table: `visibility` is in [0, 1].
    /// Every sample also needs one add_weight().
    void add(std::size_t pixel, std::uint32_t id, double filter_weight, double visibility);
    void add_weight(std::size_t pixel, double filter_weight);
    /// Adds the content of another buffer of the same size: exactly, in any order.
    Status merge(const RankedCoverage& other);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] Record record(std::size_t pixel) const;
    void restore(std::size_t pixel, const Record& record);
    /// Appends all pixels as bytes; restore_record() reads them into a buffer of the same size. After an error the
    /// buffer may contain part of the record.
    void append_record(std::string& bytes) const;
    Status restore_record(std::string_view bytes);
    [[nodiscard]] std::size_t memory_bytes() const;

    struct Rank {
        std::uint32_t id = 0;  ///< 0: this rank is empty
        double coverage = 0;
    };
    /// The `ranks.size()` ids with the largest coverage, sorted by coverage, ties by id. Returns the remainder: the
    /// coverage of everything else that has opacity.
    double resolve(std::size_t pixel, std::span<Rank> ranks) const;
    /// Calls visit(id) for every id in any pixel; it can visit an id several times.
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
