// Perceptual errors of whole images: SSIM and FLIP of the beauty.
#include <algorithm>
#include <cmath>
#include <vector>

#include "display/output/color/primaries.h"
#include "display/output/comparison/comparison.h"
#include "display/output/reader/exr_reader.h"
#include "display/services/thread_or_none.h"
#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {
namespace {

display::LinearImage seen_image(PixelArray array, const display::Chromaticities& primaries) {
    return display::in_rec709(static_cast<int>(array.width), static_cast<int>(array.height), std::move(array.values),
                              primaries);
}

/// Returns the primaries of a cell's image. Images of renderers without this information count as Rec. 709.
display::Chromaticities primaries_of(const StudyRun& cell) {
    const Result<display::ExrImage> image = display::read_exr(cell.directory + "/image.exr");
    return image ? image->chromaticities.value_or(display::rec709_primaries()) : display::rec709_primaries();
}

bool all_finite(const PixelArray& array) {
    return std::all_of(array.values.begin(), array.values.end(), [](double value) { return std::isfinite(value); });
}

void measure_row(RunErrors& row, const PixelArray& truth, const display::Chromaticities& primaries) {
    Result<PixelArray> mean = read_mean(row.run->directory, row.channel);
    if (!mean || mean->values.size() != truth.values.size() || !all_finite(*mean)) return;
    const display::LinearImage image = seen_image(*std::move(mean), primaries),
                               reference = seen_image(truth, primaries);
    for (std::size_t i = 0; i < seen_metrics.size(); ++i)
        row.seen[i] = display::measure_image(seen_metrics[i], image, reference).value;
}

}  // namespace

void measure_as_seen(Study& study) {
    for (const SceneInfo& scene : study.experiment->scenes) {
        std::vector<RunErrors*> rows;
        for (RunErrors& row : study.runs)
            if (row.run->scene == scene.name && row.region.empty() && !scene.channels.empty() &&
                row.channel == scene.channels.front().name)
                rows.push_back(&row);
        if (rows.empty()) continue;
        const Result<PixelArray> truth = read_mean(scene.reference, scene.channels.front().name);
        if (!truth || truth->components != 3 || !all_finite(*truth)) continue;
        const display::Chromaticities primaries = primaries_of(*rows.front()->run);
        display::on_threads(rows.size(), 0, [&](std::size_t i) { measure_row(*rows[i], *truth, primaries); });
    }
}

}  // namespace raylex::experiments
