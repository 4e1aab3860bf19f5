// What a job says about its files, viewers and memory, beyond the image's name.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "display/deep/deep_buffer.h"
#include "display/drivers/display_driver.h"
#include "display/output/writer/deep_file.h"
#include "display/output/writer/exr_storage.h"
#include "display/services/object_request.h"
#include "display/services/samples/word_alphabet.h"
#include "lpe/result.h"

namespace raylex::experiments {

class TomlTable;

/// Stops, either way: more says nothing, and would leave the range of floats.
inline constexpr double largest_exposure = 60;

struct DeepRequest {
    std::string file;                   ///< empty: no deep image
    std::vector<std::string> channels;  ///< beside the beauty
    SourceLocation location;
    display::DeepOptions options;
    display::DeepStorage storage;
};

/// A path atlas: raylex render --atlas.
struct AtlasRequest {
    std::string file;  ///< empty: none
    SourceLocation location;
    display::WordRules rules;
    std::uint64_t budget = std::uint64_t{2} << 30;  ///< bytes of memory; 0: none
};

struct OutputRequests {
    display::ExrStorageTable storage = display::default_exr_storage();
    bool single_part = false;  ///< of the main image and other OpenEXR files: one part with all channels
    std::vector<display::DriverRequest> drivers;  ///< beside the main image and its preview, in the order given
    std::vector<ObjectRequest> filters;           ///< display filters in the order in which they see the image
    DeepRequest deep;
    AtlasRequest atlas;
    std::uint64_t memory_limit = 0;  ///< bytes; 0 = none
};

/// "single" or "multi": how many parts an OpenEXR file has. Errors at `where`.
Status set_exr_parts(OutputRequests& outputs, const std::string& word, const SourceLocation& where);

/// What is asked for together and cannot be had together.
Status check_exr_requests(const OutputRequests& outputs);

/// "NAME.png" or "LAYER=NAME.png" as a request for the driver "png".
display::DriverRequest preview_request(const std::string& text, const SourceLocation& where);

/// "label,lobe,group,straight" in place of the rules' own, which keep their length. Errors at `where`.
Status set_atlas_rules(const std::string& text, const SourceLocation& where, AtlasRequest& atlas);

/// The tables [exr], [deep], [atlas] and [[driver]] of a job. Paths count from the job's folder.
void read_output_tables(TomlTable& root, const std::string& job_path, OutputRequests& outputs);

/// [output] tev = "host:port" and [render] memory_limit = "8G".
void read_viewer(TomlTable& output, OutputRequests& outputs);
void read_memory_limit(TomlTable& render, OutputRequests& outputs);

/// A path in a job file as seen from the current folder.
std::string beside_job(const std::string& job_path, const std::string& path);

}  // namespace raylex::experiments
