// Any bytes as a file of conformance rows: refused with its line, or run to a verdict on every row.
#include "lpe/vectors.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    fuzz::Bytes bytes(data, size);
    const Dialect dialect = bytes.below(2) == 0 ? Dialect::renderman : Dialect::osl;
    const auto report = run_vectors_text(bytes.rest(), "fuzzed.tsv", dialect);
    if (!report) {
        fuzz::require(report.error().line > 0 && !report.error().message.empty(), "a refusal names its line");
        return 0;
    }
    for (const VectorRow& row : report->disagree) {
        fuzz::require(row.line > 0 && row.found != row.expected, "a row that disagrees says what was found");
    }
    return 0;
}
