// From the parts and channels of a file to named layers; the rules stand in exr_reader.h.
#pragma once

#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

/// One flat part as it stands in the file, planes carrying full channel names.
struct FilePart {
    std::string name;
    std::vector<ImagePlane> channels;
};

std::vector<ImageLayer> name_layers(std::vector<FilePart> parts);

/// The layer that `name` means, as ExrImage::require_layer says; of several with that name behind different prefixes
/// the one with the prefix of the layer `beside` ("ViewLayer." of "ViewLayer.Combined").
Result<const ImageLayer*> resolve_layer(const ExrImage& image, std::string_view name, std::string_view beside = {});
/// Layers that a glob matches, in the file's order; when none does, those that it matches without the prefix of
/// `beside` or the one that all names share.
std::vector<const ImageLayer*> layers_like(const ExrImage& image, std::string_view glob, std::string_view beside);
/// Every layer's name, and what is left of it without the part up to a dot or the beginning that all share.
std::vector<std::string> spoken_names(const ExrImage& image);
/// What all names of layers begin with, up to and with a '.', '_' or '-'; empty for a single layer.
std::string_view shared_prefix(const ExrImage& image);
/// The layer that other renderers' habits suggest as the whole image: Ci, C, RGBA, Combined, ...; empty when none does.
std::string likely_beauty(const ExrImage& image);

/// The text of a "partition/NAME" attribute, "beauty = diffuse + specular", and back.
std::string format_partition(const PartitionDeclaration& partition);
PartitionDeclaration parse_partition(const std::string& name, const std::string& text);

/// "a, b, c" for messages, shortened after 40 names; the nameless layer is called beauty.
std::string list_names(const std::vector<std::string>& names);

}  // namespace raylex::display
