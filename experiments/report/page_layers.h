// The layers of an image inside a page: their pixels, a row for each layer, and the data for split_page.js.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "display/output/color/color_manager.h"
#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "experiments/report/page.h"
#include "lpe/result.h"

namespace raylex::experiments {

std::string_view mix_script();  ///< mix.js

class PageLayers {
  public:
    /// `image_bytes`: approximate limit for the pixels of one image, unless the options set a size.
    PageLayers(const display::ColorManager& color, const PageOptions& options, std::size_t image_bytes)
        : color_(color), options_(options), image_bytes_(image_bytes) {}

    /// Viewer, rows and data of one image. If no layer can be shown, the section says so instead. Results that do not
    /// hold add a row for unassigned light and one for light that is counted twice.
    Result<std::string> html(const display::ExrImage& image, const std::vector<display::SplitResult>& results = {});

    /// The tables of all views that the images use. A page contains them once.
    [[nodiscard]] std::string view_scripts() const;

  private:
    struct Row;
    struct View {
        std::string name;
        std::size_t table = 0;  ///< in tables_
    };
    Result<std::vector<View>> views_of(const display::ExrImage& image);
    Result<Row> row_of(const display::ExrImage& image, const display::ImageLayer& layer, int block, bool may_fold);
    [[nodiscard]] int block_of(const display::ExrImage& image, std::size_t more_planes) const;

    const display::ColorManager& color_;
    const PageOptions& options_;
    std::size_t image_bytes_;
    std::size_t next_data_ = 0;        ///< number of the next element with pixels
    std::vector<std::string> tables_;  ///< packed views, each once
};

}  // namespace raylex::experiments
