// The description of an image in a record. It has everything except the sums that the image file is written from, so
// the merged file equals that of a single render.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"
#include "display/services/object_request.h"
#include "experiments/job/text/json.h"
#include "geoaovs/cryptomatte.h"

namespace raylex::experiments {

/// A cryptomatte without its coverage, which is the record's section of the same name.
struct RecordedMatte {
    geoaovs::MatteKind kind = geoaovs::MatteKind::object;
    int ranks = geoaovs::Cryptomatte::default_ranks;
    std::vector<std::string> names;
};

struct RecordedImage {
    display::ImageDescription description;  ///< without its data parts
    display::ChannelId beauty = display::invalid_channel;
    std::vector<RecordedMatte> mattes;
    std::vector<ObjectRequest> filters;  ///< display filters, in order of application
};

/// Returns the image as JSON. Cells and renders may add their own members.
Json image_json(const RecordedImage& image);

/// Parses the JSON of image_json(). Throws std::exception for any other JSON.
RecordedImage image_of(const Json& json);

}  // namespace raylex::experiments
