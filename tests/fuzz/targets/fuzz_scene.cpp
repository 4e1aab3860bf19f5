// Any bytes as a pbrt scene: a scene, or a refusal with its line. Types are not known here (empty_registries.cpp), so
// that their parameters pass as they are written.
#include "tests/fuzz/fuzz.h"
#include "transport/import/pbrt/pbrt_importer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const auto scene = raylex::transport::import_pbrt_text(fuzz::Bytes(data, size).rest(), "/fuzzed/scene.pbrt");
    if (!scene)
        fuzz::require(!scene.error().message.empty() && !scene.error().to_string().empty(), "a refusal says why");
    return 0;
}
