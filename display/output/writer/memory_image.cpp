#include "display/output/writer/memory_image.h"

#include "display/output/reader/exr_layers.h"
#include "display/output/writer/exr_layout.h"
#include "display/output/writer/exr_pixels.h"

namespace raylex::display {

namespace {

/// The part as a file with empty planes, enough to find the layers that it forms.
FilePart named_part(const PlannedPart& part) {
    FilePart file{part.name, {}};
    for (const std::string& plane : part.planes) file.channels.push_back({plane, part.storage.type, {}});
    return file;
}

void fill(FilePart& file, const PlannedPart& part, const PixelImage& frame_buffer) {
    if (part.data != nullptr) {
        const std::vector<float> values = part.data->values(frame_buffer.whole());
        const std::size_t size = values.size() / file.channels.size();
        for (std::size_t p = 0; p < file.channels.size(); ++p) {
            const auto begin = values.begin() + static_cast<std::ptrdiff_t>(p * size);
            file.channels[p].values.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
        }
        return;
    }
    const ChannelDefinition& channel = frame_buffer.channels()[static_cast<std::size_t>(part.channel)];
    const auto components = static_cast<std::size_t>(component_count(channel.type));
    const std::vector<double> pixels = frame_buffer.resolve(part.channel);
    for (std::size_t c = 0; c < components; ++c)
        for (std::size_t i = c; i < pixels.size(); i += components)
            file.channels[c].values.push_back(static_cast<float>(pixels[i]));
    if (!part.alpha) return;
    for (const double each : frame_buffer.resolve_alpha())
        file.channels[components].values.push_back(static_cast<float>(each));
}

ExrImage empty_image(const PixelImage& frame_buffer, const ImageDescription& description) {
    ExrImage image;
    image.width = frame_buffer.layout().width;
    image.height = frame_buffer.layout().height;
    image.data_window = description.data_window;
    image.chromaticities = description.chromaticities;
    return image;
}

}  // namespace

ExrImage image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description) {
    ExrImage image = empty_image(frame_buffer, description);
    std::vector<FilePart> all;
    for (const PlannedPart& part : plan_parts(frame_buffer.channels(), beauty, description)) {
        fill(all.emplace_back(named_part(part)), part, frame_buffer);
        for (const auto& [name, text] : part.attributes) image.attributes.emplace(name, text);
    }
    image.layers = name_layers(std::move(all));
    for (ImageLayer& layer : image.layers)
        for (ImagePlane& plane : layer.planes)
            if (plane.stored == StoredType::half_float) plane.stored = StoredType::single_float;
    for (const PartitionDeclaration& partition : description.partitions)
        if (is_declared(frame_buffer.channels(), beauty, partition)) image.partitions.push_back(partition);
    for (const auto& [name, text] : description.attributes) image.attributes.emplace(name, text);
    return image;
}

Result<ExrImage> image_in_memory(const PixelImage& frame_buffer, ChannelId beauty, const ImageDescription& description,
                                 const std::string& layer) {
    const std::vector<PlannedPart> parts = plan_parts(frame_buffer.channels(), beauty, description);
    ExrImage image = empty_image(frame_buffer, description);
    std::vector<FilePart> all;
    for (const PlannedPart& part : parts) all.push_back(named_part(part));
    image.layers = name_layers(std::move(all));
    std::string wanted = layer == "beauty" ? "" : layer;
    const ImageLayer* found = nullptr;
    if (wanted.empty() && image.layer("") == nullptr && !image.layers.empty()) found = &image.layers.front();
    else {
        auto required = image.require_layer(wanted);
        if (!required) return required.error();
        found = *required;
    }
    wanted = found->name;
    const std::string part_name = found->part;
    for (const PlannedPart& part : parts) {
        if (part.name != part_name) continue;
        std::vector<FilePart> one{named_part(part)};
        fill(one.front(), part, frame_buffer);
        image.layers = name_layers(std::move(one));
        break;
    }
    std::erase_if(image.layers, [&](const ImageLayer& each) { return each.name != wanted; });
    return image;
}

}  // namespace raylex::display
