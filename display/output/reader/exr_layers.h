// Converts parts and channels of a file to named layers; exr_reader.h has the rules.
#pragma once

#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

/// A flat part as in the file, with full channel names.
struct FilePart {
    std::string name;
    std::vector<ImagePlane> channels;
};

std::vector<ImageLayer> name_layers(std::vector<FilePart> parts);

/// Finds the layer that `name` denotes, by the rules of ExrImage::require_layer(). If several prefixes have that name,
/// the layer with the prefix of the layer `beside` is taken ("ViewLayer." of "ViewLayer.Combined").
Result<const ImageLayer*> resolve_layer(const ExrImage& image, std::string_view name, std::string_view beside = {});
/// The layers that match a glob, in the order of the file. If there are none, the layers that match without the prefix
/// of `beside`, or without the prefix that all names share.
std::vector<const ImageLayer*> layers_like(const ExrImage& image, std::string_view glob, std::string_view beside);
/// Every layer's name, also without its prefix up to a dot, and without the prefix that all names share.
std::vector<std::string> spoken_names(const ExrImage& image);
/// The common prefix of all layer names, up to and including a '.', '_' or '-'; empty for a single layer.
std::string_view shared_prefix(const ExrImage& image);
/// The layer that other renderers typically use for the whole image: Ci, C, RGBA, Combined, ...; empty if there is
/// none.
std::string likely_beauty(const ExrImage& image);

/// The text of a "partition/NAME" attribute: "beauty = diffuse + specular". parse_partition() reads it.
std::string format_partition(const PartitionDeclaration& partition);
PartitionDeclaration parse_partition(const std::string& name, const std::string& text);

/// A list for messages: "a, b, c", shortened after 40 names; the nameless layer is named beauty.
std::string list_names(const std::vector<std::string>& names);

}  // namespace raylex::display
