// Merges several atlases of one scene: shards, passes, or renders with other seeds.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns a description for the atlas of a shard, with an attribute for the samples [first, end).
display::ImageDescription of_samples(display::ImageDescription description, std::uint64_t first, std::uint64_t end);

/// The merged atlas. The beauty, and every word of a pixel, is the mean over the files, weighted by the pixel's number
/// of samples. The words of a pixel are added in an order that depends only on their values, so the order of the files
/// does not change a bit. A class can appear beside words that another file did not merge; both are correct.
class MergedAtlas final : public display::AtlasSource {
  public:
    /// Opens the files. Errors name two files and their difference: size, word rules, the events of the scene,
    /// integrator, filter, colours, or other settings of the job than samples, seed, threads and outputs. Other errors:
    /// samples that two files share; signed atlases.
    static Result<std::unique_ptr<MergedAtlas>> open(const std::vector<std::string>& paths);

    [[nodiscard]] int width() const override { return files_.front()->width(); }
    [[nodiscard]] int height() const override { return files_.front()->height(); }
    [[nodiscard]] const display::PathStringTable& table() const override { return table_; }
    Status row(int y, display::AtlasRow& row) override;
    /// Returns the description of the first file, with sums and lists over all files.
    [[nodiscard]] display::ImageDescription description() const;

  private:
    MergedAtlas() = default;
    Status join_tables();
    struct Part {
        std::uint32_t word = 0;
        double samples = 0;
        const display::PathStringSample* sample = nullptr;
    };
    void merge_pixel(std::size_t x, display::AtlasRow& row);
    std::vector<std::unique_ptr<display::AtlasFile>> files_;
    std::vector<display::AtlasRow> rows_;                // [file]
    std::vector<std::vector<std::uint32_t>> number_of_;  // [file][word]
    display::PathStringTable table_;
    std::vector<Part> parts_;
};

}  // namespace raylex::experiments
