// From the parts and channels of a file to named layers; the rules stand in exr_reader.h.
#pragma once

#include <string>
#include <vector>

#include "display/output/exr_reader.h"

namespace raylex::display {

/// One flat part as it stands in the file, planes carrying full channel names.
struct FilePart {
    std::string name;
    std::vector<ImagePlane> channels;
};

std::vector<ImageLayer> name_layers(std::vector<FilePart> parts);

/// The text of a "partition/NAME" attribute, "beauty = diffuse + specular", and back.
std::string format_partition(const PartitionDeclaration& partition);
PartitionDeclaration parse_partition(const std::string& name, const std::string& text);

/// "a, b, c" for messages, shortened after 40 names; the nameless layer is called beauty.
std::string list_names(const std::vector<std::string>& names);

}  // namespace raylex::display
