// Requests of a job about files, viewers and memory, except the name of the image.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "display/deep/deep_buffer.h"
#include "display/drivers/display_driver.h"
#include "display/output/writer/deep_file.h"
#include "display/output/writer/exr_storage.h"
#include "display/services/object_request.h"
#include "display/services/samples/path_alphabet.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;
struct Job;

/// Largest exposure in stops, positive or negative. More would leave the range of float.
inline constexpr double largest_exposure = 60;

struct DeepRequest {
    std::string file;                   ///< empty: no deep image
    std::vector<std::string> channels;  ///< channels besides the beauty
    SourceLocation location;
    display::DeepOptions options;
    display::DeepStorage storage;
};

/// A request for a path atlas: raylex render --atlas.
struct AtlasRequest {
    std::string file;  ///< empty: no atlas
    SourceLocation location;
    display::PathStringRules rules{.length = 0};    ///< length 0: the maximum depth of the render's paths
    std::uint64_t budget = std::uint64_t{2} << 30;  ///< bytes of memory; 0: no limit
};

struct OutputRequests {
    display::ExrStorageTable storage = display::default_exr_storage();
    bool single_part = false;  ///< OpenEXR files have one part with all channels
    /// drivers besides the main image and its preview, in the order given
    std::vector<display::DriverRequest> drivers;
    std::vector<ObjectRequest> filters;  ///< display filters, in order of application
    DeepRequest deep;
    AtlasRequest atlas;
    bool denoise = false;            ///< denoises the layers of the written image
    bool keep_noisy = false;         ///< keeps the noisy layers beside the denoised ones
    std::uint64_t memory_limit = 0;  ///< bytes; 0: no limit
};

/// Parses "single" or "multi": the number of parts of OpenEXR files. Errors are at `where`.
Status set_exr_parts(OutputRequests& outputs, const std::string& word, const SourceLocation& where);

/// Returns an error for requests that exclude one another.
Status check_exr_requests(const OutputRequests& outputs);

/// Returns "NAME.png" or "LAYER=NAME.png" as a request for the driver "png".
display::DriverRequest preview_request(const std::string& text, const SourceLocation& where);

/// Sets the word rules from "label,lobe,group,straight"; the length stays. Errors are at `where`.
Status set_atlas_rules(const std::string& text, const SourceLocation& where, AtlasRequest& atlas);

/// Reads the tables [exr], [deep], [atlas] and [[driver]] of a job. Paths are relative to the job's folder.
void read_output_tables(TomlTable& root, const std::string& job_path, Job& job);

/// Reads [[key]] tables with a type and its parameters, in their order.
std::vector<ObjectRequest> read_objects(TomlTable& root, const char* key);

/// Returns a path in a job file relative to the current folder.
std::string relative_to_job(const std::string& job_path, const std::string& path);

}  // namespace raylex::experiments
