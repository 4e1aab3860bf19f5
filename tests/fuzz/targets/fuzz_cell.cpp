// Any bytes as the record of a study's cell: a cell that comes back as the same text, or a refusal that names the file.
#include "experiments/study/results_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace raylex::experiments;
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const auto run = run_of_text(fuzz::Bytes(data, size).rest(), "fuzzed");
    if (!run) {
        fuzz::require(run.error().file == "fuzzed", "a refusal names the file: " + run.error().message);
        return 0;
    }
    const std::string text = run_text(*run);
    const auto again = run_of_text(text, "written");
    fuzz::require(again.ok() && run_text(*again) == text, "what was read can be written and read: " + text);
    return 0;
}
