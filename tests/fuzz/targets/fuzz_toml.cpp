// Any bytes as TOML: a table, or a refusal with line and column. What is refused for its depth is not parsed.
#include "experiments/job/text/toml_text.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const auto table = raylex::experiments::parse_toml(fuzz::Bytes(data, size).rest(), "fuzzed");
    if (!table) fuzz::require(table.error().line > 0, "a refusal names its line: " + table.error().message);
    return 0;
}
