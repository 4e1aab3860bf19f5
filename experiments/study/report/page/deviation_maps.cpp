// Maps of noise: the standard deviation of every pixel over replicates, as pictures with one scale per scene.
#include <algorithm>

#include "display/output/color/color_manager.h"
#include "display/output/comparison/comparison.h"
#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/pictures.h"
#include "experiments/study/report/page/study_tables.h"

namespace raylex::experiments {
namespace {

struct Maps {
    std::vector<const ErrorSpectrum*> spectra;
    double most = 0;  ///< top of the scale, robust against fireflies
};

Maps maps_of(const Study& study, const std::string& scene) {
    Maps maps;
    std::vector<double> all;
    for (const ErrorSpectrum& each : study.spectra) {
        if (each.curve->scene != scene || each.deviation.values.empty()) continue;
        maps.spectra.push_back(&each);
        all.insert(all.end(), each.deviation.values.begin(), each.deviation.values.end());
    }
    if (all.empty()) return maps;
    const auto place = all.begin() + static_cast<std::ptrdiff_t>((all.size() - 1) * 99 / 100);
    std::nth_element(all.begin(), place, all.end());
    maps.most = *place;
    return maps;
}

}  // namespace

std::string deviation_maps(const Study& study, const SceneInfo& scene) {
    const Maps maps = maps_of(study, scene.name);
    std::string figures;
    for (const ErrorSpectrum* each : maps.spectra) {
        const PixelArray map =
            reduced(each->deviation, 1 + std::max(each->deviation.width, each->deviation.height) / 640);
        const auto png = display::encode_png(static_cast<int>(map.width), static_cast<int>(map.height),
                                             display::error_colors(map.values, maps.most));
        if (!png) continue;
        const std::string name = escape_html(each->curve->variant);
        figures += "<figure class=\"residual\"><img alt=\"standard deviation of " + name + "\" src=\"" +
                   data_uri(*png) + "\"><figcaption>" + name + ", " + counted(each->replicates, "replicate") +
                   "</figcaption></figure>\n";
    }
    if (figures.empty()) return {};
    return "<h3>Standard deviation of every pixel</h3>\n<p class=\"note\">Standard deviation of the beauty over "
           "replicates at the "
           "largest "
           "budget, relative to the mean of the image. Black: 0; pale yellow: " +
           percent_text(maps.most) + " and above.</p>\n<div class=\"residuals\">" + figures + "</div>\n";
}

Result<std::size_t> write_deviation_maps(const Study& study, const std::string& folder) {
    std::size_t files = 0;
    for (const SceneInfo& scene : study.experiment->scenes) {
        const Maps maps = maps_of(study, scene.name);
        for (const ErrorSpectrum* each : maps.spectra) {
            const std::string path =
                folder + "/" + file_part(scene.name) + "." + file_part(each->curve->variant) + ".deviation.png";
            if (Status s = display::write_error_png(path, each->deviation.values, scene.width, scene.height, maps.most);
                !s)
                return s.error();
            ++files;
        }
    }
    return files;
}

}  // namespace raylex::experiments
