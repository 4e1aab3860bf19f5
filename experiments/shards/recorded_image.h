// What the image of a record says of itself: all that a file is written from beside the sums, so that whoever adds
// records up writes the very file that one render of all samples would have written.
#pragma once

#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"
#include "display/services/object_request.h"
#include "experiments/job/text/json.h"
#include "geoaovs/cryptomatte.h"

namespace raylex::experiments {

/// A set of mattes without its coverage, which is a section of the record by the set's name.
struct RecordedMatte {
    geoaovs::MatteKind kind = geoaovs::MatteKind::object;
    int ranks = geoaovs::Cryptomatte::default_ranks;
    std::vector<std::string> names;
};

struct RecordedImage {
    display::ImageDescription description;  ///< without its data parts
    display::ChannelId beauty = display::invalid_channel;
    std::vector<RecordedMatte> mattes;
    std::vector<ObjectRequest> filters;  ///< display filters, in the order in which they see the image
};

/// As JSON; cells and renders may add members of their own.
Json image_json(const RecordedImage& image);

/// What image_json() was made from. Throws std::exception where the JSON is something else.
RecordedImage image_of(const Json& json);

}  // namespace raylex::experiments
