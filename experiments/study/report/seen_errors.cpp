// Errors of whole images as people see them: SSIM and FLIP of the beauty, from the images that cells keep.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "display/output/comparison.h"
#include "display/output/exr_reader.h"
#include "experiments/study/report/study.h"

namespace raylex::experiments {
namespace {

void measure_row(CellErrors& row, const display::ExrImage& reference) {
    const Result<display::ExrImage> image = display::read_exr(row.cell->directory + "/image.exr");
    if (!image) return;
    const Result<display::LayerPair> pair = display::LayerPair::make(*image, reference, "");
    if (!pair) return;
    for (std::size_t i = 0; i < seen_metrics.size(); ++i) {
        display::AnyMetric metric;
        metric.of_image = seen_metrics[i];
        if (const Result<double> value = pair->value(metric, 0)) row.seen[i] = *value;
    }
}

}  // namespace

void measure_as_seen(Study& study) {
    for (const SceneInfo& scene : study.experiment->scenes) {
        if (scene.reference.empty()) continue;
        const auto beauty = std::find_if(scene.channels.begin(), scene.channels.end(),
                                         [](const ChannelInfo& each) { return each.beauty; });
        std::vector<CellErrors*> rows;
        for (CellErrors& row : study.cells)
            if (beauty != scene.channels.end() && row.cell->scene == scene.name && row.channel == beauty->name &&
                row.region.empty())
                rows.push_back(&row);
        if (rows.empty()) continue;
        const Result<display::ExrImage> reference = display::read_exr(scene.reference + "/image.exr");
        if (!reference) continue;
        std::atomic<std::size_t> next{0};
        const auto work = [&] {
            for (std::size_t i; (i = next.fetch_add(1)) < rows.size();) measure_row(*rows[i], *reference);
        };
        std::vector<std::jthread> others(std::min<std::size_t>(std::thread::hardware_concurrency(), rows.size()) - 1);
        for (std::jthread& each : others) each = std::jthread(work);
        work();
    }
}

}  // namespace raylex::experiments
