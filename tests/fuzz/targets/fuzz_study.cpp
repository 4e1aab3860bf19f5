// Any bytes as a study's config and the --set that changes it, parted by a line of ---.
#include "experiments/study/plan/config_text.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    std::string text = fuzz::Bytes(data, size).rest();
    std::vector<std::string> overrides;
    for (std::size_t at; (at = text.rfind("\n---\n")) != std::string::npos && overrides.size() < 8;) {
        overrides.push_back(text.substr(at + 5));
        text.resize(at);
    }
    const raylex::experiments::ConfigText config("fuzzed", text, overrides);
    const auto table = config.parse();
    if (!table)
        fuzz::require(table.error().line > 0 || table.error().file.starts_with("--set"),
                      "a refusal names its line or its --set: " + table.error().to_string());
    return 0;
}
