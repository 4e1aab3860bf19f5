#include "experiments/study/report/page/pictures.h"

#include <algorithm>
#include <cmath>

#include "experiments/report/pixel_data.h"
#include "experiments/study/report/measures/study_files.h"

namespace raylex::experiments {
namespace {

/// Returns the cell shown for a variant on a scene: the first replicate of the largest budget.
const StudyRun* shown_cell(const Study& study, const std::string& scene, const std::string& variant) {
    const StudyRun* shown = nullptr;
    const auto larger = [](const StudyRun& a, const StudyRun& b) {
        if (a.budget_kind != b.budget_kind || a.budget == b.budget) return false;
        return a.budget_kind == BudgetKind::error ? a.budget < b.budget : a.budget > b.budget;
    };
    for (const StudyRun& cell : study.experiment->runs)
        if (!cell.failed && cell.scene == scene && variant_name(cell) == variant &&
            (shown == nullptr || larger(cell, *shown) ||
             (cell.budget == shown->budget && cell.replicate < shown->replicate)))
            shown = &cell;
    return shown;
}

Pictures encode_all(const Study& study, const std::vector<PictureSource>& sources, std::size_t block) {
    Pictures result;
    for (std::size_t s = 0; s < study.experiment->scenes.size(); ++s) {
        const SceneInfo& scene = study.experiment->scenes[s];
        const auto b = static_cast<int>(block);
        ScenePictures pictures{scene.name, (scene.width + b - 1) / b, (scene.height + b - 1) / b, b, {}, {}};
        for (const ChannelInfo& channel : scene.channels) pictures.channels.push_back(channel.name);
        for (const PictureSource& source : sources) {
            if (source.scene != s) continue;
            PictureSet set{source.name, {}};
            std::string problem;
            bool any = false;
            for (const ChannelInfo& channel : scene.channels) {
                Result<PixelArray> image = read_mean(source.directory, channel.name);
                const bool fits = image && image->width == static_cast<std::size_t>(scene.width) &&
                                  image->components == 3 && image->height == static_cast<std::size_t>(scene.height);
                if (!fits) {
                    problem = image ? channel.name + " in " + source.directory + " does not have the scene's size"
                                    : image.error().to_string();
                    set.ids.push_back(std::nullopt);
                    continue;
                }
                any = true;
                set.ids.push_back(result.encoded.size());
                result.encoded.push_back(encode_picture(reduced(*image, block)));
                result.bytes += result.encoded.back().size();
            }
            if (any) pictures.images.push_back(std::move(set));
            else result.left_out.push_back(source.name + ": " + problem);
        }
        if (!pictures.images.empty()) result.scenes.push_back(std::move(pictures));
    }
    return result;
}

}  // namespace

std::vector<PictureSource> picture_sources(const Study& study) {
    std::vector<PictureSource> sources;
    for (std::size_t s = 0; s < study.experiment->scenes.size(); ++s) {
        const SceneInfo& scene = study.experiment->scenes[s];
        for (const MethodVariant& variant : study.variants)
            if (const StudyRun* cell = shown_cell(study, scene.name, variant.name))
                sources.push_back({s, cell->directory, variant.name,
                                   variant.name + ", " + spoken_budget(cell->budget_kind, cell->budget)});
        if (!scene.reference.empty()) sources.push_back({s, scene.reference, {}, "reference"});
    }
    return sources;
}

PixelArray reduced(const PixelArray& image, std::size_t block) {
    if (block <= 1) return image;
    PixelArray result{(image.height + block - 1) / block, (image.width + block - 1) / block, image.components, {}};
    result.values.reserve(result.height * result.width * result.components);
    for (std::size_t y = 0; y < image.height; y += block)
        for (std::size_t x = 0; x < image.width; x += block)
            for (std::size_t c = 0; c < image.components; ++c) {
                double sum = 0, count = 0;
                for (std::size_t v = y; v < std::min(y + block, image.height); ++v)
                    for (std::size_t u = x; u < std::min(x + block, image.width); ++u, ++count)
                        sum += image.values[(v * image.width + u) * image.components + c];
                result.values.push_back(sum / count);
            }
    return result;
}

std::string encode_picture(const PixelArray& image) {
    const std::size_t pixels = image.width * image.height;
    std::vector<float> planes(pixels * image.components);
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
        for (std::size_t c = 0; c < image.components; ++c)
            planes[c * pixels + pixel] = static_cast<float>(image.values[pixel * image.components + c]);
    return pack_halves(planes);
}

Pictures pictures_of(const Study& study) {
    const std::vector<PictureSource> sources = picture_sources(study);
    double pixels = 0;
    for (const PictureSource& source : sources) {
        const SceneInfo& scene = study.experiment->scenes[source.scene];
        pixels += static_cast<double>(scene.width) * scene.height * static_cast<double>(scene.channels.size());
    }
    // Packed noise takes about 4 bytes per pixel, 16 / 3 in base64, so much smaller factors need not be tried.
    const double budget = static_cast<double>(study.options.picture_bytes);
    auto block = static_cast<std::size_t>(std::max(1.0, std::floor(std::sqrt(pixels * 16 / 3 / 2 / budget))));
    Pictures pictures = encode_all(study, sources, block);
    while (pictures.bytes > study.options.picture_bytes && block < 4096) pictures = encode_all(study, sources, ++block);
    return pictures;
}

}  // namespace raylex::experiments
