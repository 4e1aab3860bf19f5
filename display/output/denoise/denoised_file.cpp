// The file of a denoised image: a copy of the noisy one with other layers.
#include <algorithm>

#include "display/output/denoise/denoised_image.h"
#include "display/output/splits/split_sum.h"
#include "display/output/writer/exr_edit.h"

namespace raylex::display {

namespace {

/// The results of the checks that readers find in the header.
Status add_results(const ExrImage& image, DenoisedImage& denoised) {
    auto results = check_declared_splits(image);
    if (!results) return results.error();
    for (const SplitResult& result : *results)
        denoised.attributes["verdict/" + result.partition] = result_attribute(result, result.layers.size());
    return success();
}

/// A layer as a part of its own, whose values the image keeps.
DataPart part_of(const ImageLayer& layer, int width) {
    DataPart part;
    part.name = layer.name;
    for (const ImagePlane& plane : layer.planes)
        part.planes.push_back(plane.name == layer.name ? layer.name : layer.name + "." + plane.name);
    part.values = [&layer, width](const PixelRegion& rows) {
        std::vector<float> all;
        for (const ImagePlane& plane : layer.planes)
            all.insert(all.end(), plane.values.begin() + std::ptrdiff_t{width} * rows.y0,
                       plane.values.begin() + std::ptrdiff_t{width} * rows.y1);
        return all;
    };
    return part;
}

/// The edit that gives a file the layers of a denoised image.
ExrEdit edit_of(const ExrImage& image, DenoisedImage& denoised) {
    ExrEdit edit;
    std::vector<const ImagePlane*> sources;
    for (const DenoisedLayer& each : denoised.layers) {
        for (const ImagePlane& plane : std::span(image.layer(each.name)->planes).first(3)) {
            const ExrChannel place{plane.part, plane.channel};
            if (!edit.changed.insert(place).second) continue;
            edit.planes.push_back(place);
            sources.push_back(&plane);
        }
    }
    edit.changed_to_float = true;
    edit.change = [sources, width = image.width, height = image.height, &overscan = denoised.has_overscan](
                      const PixelRegion& band, std::span<std::vector<float>> planes) {
        overscan = overscan || band.x0 < 0 || band.y0 < 0 || band.x1 > width || band.y1 > height;
        const int x0 = std::max(band.x0, 0), x1 = std::min(band.x1, width);
        for (std::size_t p = 0; p < planes.size() && x0 < x1; ++p)
            for (int y = std::max(band.y0, 0); y < std::min(band.y1, height); ++y) {
                const auto from = sources[p]->values.begin() + std::ptrdiff_t{width} * y;
                std::copy(from + x0, from + x1,
                          planes[p].begin() + std::ptrdiff_t{band.x1 - band.x0} * (y - band.y0) + x0 - band.x0);
            }
    };
    for (const ImageLayer& layer : denoised.removed)
        for (const ImagePlane& plane : layer.planes) edit.removed.insert({plane.part, plane.channel});
    for (const std::string& name : denoised.added) edit.added.push_back(part_of(*image.layer(name), image.width));
    edit.attributes = denoised.attributes;
    edit.drops_attribute = [&denoised](const std::string& name) {
        const auto is_of = [&](const auto& layer) { return name == "storage/" + layer.name; };
        return std::ranges::any_of(denoised.layers, is_of) ||
               std::ranges::any_of(denoised.removed, [&](const ImageLayer& layer) {
                   return is_of(layer) || name == "rule/" + layer.name || name == "statistics/" + layer.name;
               });
    };
    return edit;
}

}  // namespace

Result<DenoisedImage> denoise_exr(const std::string& from, const std::string& to, const DenoiseOptions& options) {
    auto image = read_exr(from);
    if (!image) return image.error();
    auto denoised = denoise_image(*image, options);
    if (!denoised) return denoised;
    if (Status results = add_results(*image, *denoised); !results) return results.error();
    const ExrEdit edit = edit_of(*image, *denoised);
    if (Status written = edit_exr(from, to, edit); !written) return written.error();
    return denoised;
}

}  // namespace raylex::display
