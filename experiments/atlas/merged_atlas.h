// Several atlases of one scene as one: shards, passes, renders with other seeds.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// What the header of a shard's atlas says: that it is of samples [first, end) alone.
display::ImageDescription of_samples(display::ImageDescription description, std::uint64_t first, std::uint64_t end);

/// Every pixel and word is the mean over the files, weighted by the pixel's samples, as is the beauty. Words of one
/// pixel are added in an order that depends on their values alone, so the order of the files does not matter, bit for
/// bit. A class stands beside the words that another file still kept apart: both are honest.
class MergedAtlas final : public display::AtlasSource {
  public:
    /// Errors name two files and what differs: size, what words are told apart by, what the scene can produce,
    /// integrator, filter, colours, the job but for samples, seed, threads and outputs; samples that two have; signed
    /// atlases.
    static Result<std::unique_ptr<MergedAtlas>> open(const std::vector<std::string>& paths);

    [[nodiscard]] int width() const override { return files_.front()->width(); }
    [[nodiscard]] int height() const override { return files_.front()->height(); }
    [[nodiscard]] const display::WordTable& table() const override { return table_; }
    Status row(int y, display::AtlasRow& row) override;
    /// Of the first file, with what is the sum or the list of all.
    [[nodiscard]] display::ImageDescription description() const;

  private:
    MergedAtlas() = default;
    Status join_tables();
    struct Part {
        std::uint32_t word = 0;
        double samples = 0;
        const display::WordSample* sample = nullptr;
    };
    void merge_pixel(std::size_t x, display::AtlasRow& row);
    std::vector<std::unique_ptr<display::AtlasFile>> files_;
    std::vector<display::AtlasRow> rows_;                // [file]
    std::vector<std::vector<std::uint32_t>> number_of_;  // [file][word]
    display::WordTable table_;
    std::vector<Part> parts_;
};

}  // namespace raylex::experiments
