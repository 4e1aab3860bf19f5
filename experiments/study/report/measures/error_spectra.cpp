// Error spectra, and the standard deviation of every pixel, from the replicates of a study.
#include <algorithm>
#include <cmath>

#include "display/services/thread_or_none.h"
#include "experiments/study/analysis/spectrum.h"
#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {
namespace {

/// Returns the images of a curve's largest budget minus the reference. Sets `reference` to the reference's standard
/// error.
std::vector<PixelArray> errors_of(const Study& study, const PixelArray& truth, const Curve& curve, double& reference) {
    std::vector<PixelArray> errors;
    for (const RunErrors& row : study.runs) {
        if (row.run->scene != curve.scene || row.variant != curve.variant || row.channel != curve.channel ||
            !row.region.empty() || row.run->budget != curve.points.back().budget)
            continue;
        Result<PixelArray> image = read_mean(row.run->directory, curve.channel);
        if (!image || image->values.size() != truth.values.size()) continue;
        for (std::size_t i = 0; i < truth.values.size(); ++i) image->values[i] -= truth.values[i];
        errors.push_back(*std::move(image));
        reference = std::sqrt(row.mse_excess);
    }
    return errors;
}

void add_replicate(ErrorSpectrum& spectrum, const std::vector<FrequencyRing>& rings) {
    const auto before = static_cast<double>(spectrum.replicates++);
    if (spectrum.points.empty())
        for (const FrequencyRing& ring : rings) spectrum.points.push_back({ring.frequency, 0, ring.power, ring.power});
    for (std::size_t i = 0; i < rings.size(); ++i) {
        ErrorSpectrum::Point& point = spectrum.points[i];
        point.mean = (point.mean * before + rings[i].power) / (before + 1);
        point.least = std::min(point.least, rings[i].power);
        point.most = std::max(point.most, rings[i].power);
    }
}

PixelArray deviation_of(const std::vector<PixelArray>& images) {
    const PixelArray& shape = images.front();
    const auto n = static_cast<double>(images.size());
    PixelArray map{shape.height, shape.width, 1, std::vector<double>(shape.height * shape.width)};
    for (std::size_t i = 0; i < shape.values.size(); ++i) {
        double mean = 0, squares = 0;
        for (const PixelArray& image : images) mean += image.values[i] / n;
        for (const PixelArray& image : images) squares += std::pow(image.values[i] - mean, 2);
        map.values[i / shape.components] += squares / (n - 1) / static_cast<double>(shape.components);
    }
    for (double& each : map.values) each = std::sqrt(each);
    return map;
}

void measure(const Study& study, const SceneInfo& scene, ErrorSpectrum& spectrum) {
    const Result<PixelArray> truth = read_mean(scene.reference, spectrum.curve->channel);
    if (!truth) return;
    double mean = 0;
    for (const double each : truth->values) mean += std::abs(each) / static_cast<double>(truth->values.size());
    if (!(mean > 0)) return;
    std::vector<PixelArray> errors = errors_of(study, *truth, *spectrum.curve, spectrum.reference_error);
    spectrum.reference_error /= mean;
    for (PixelArray& image : errors) {
        for (double& each : image.values) each /= mean;
        add_replicate(spectrum, radial_spectrum(image));
    }
    if (errors.size() > 1 && spectrum.curve->channel == scene.channels.front().name)
        spectrum.deviation = deviation_of(errors);
}

}  // namespace

void measure_spectra(Study& study) {
    for (const Curve& curve : study.curves)
        if (curve.region.empty() && !curve.points.empty()) study.spectra.push_back({&curve, 0, 0, {}, {}});
    display::on_threads(study.spectra.size(), 0, [&](std::size_t i) {
        for (const SceneInfo& scene : study.experiment->scenes)
            if (scene.name == study.spectra[i].curve->scene) measure(study, scene, study.spectra[i]);
    });
    std::erase_if(study.spectra, [](const ErrorSpectrum& each) { return each.points.empty(); });
}

}  // namespace raylex::experiments
