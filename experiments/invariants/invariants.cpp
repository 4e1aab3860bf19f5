#include "experiments/invariants/invariants.h"

#include <algorithm>

#include "display/services/parameters.h"
#include "experiments/invariants/scene_under_test.h"

namespace raylex::experiments {
namespace {

std::vector<const Invariant*> all_invariants() {
    std::vector<const Invariant*> all;
    for (const auto* list : {&invariants_of_bits(), &invariants_of_means()})
        for (const Invariant& each : *list) all.push_back(&each);
    return all;
}

}  // namespace

std::vector<InvariantInfo> invariants() {
    std::vector<InvariantInfo> infos;
    for (const Invariant* each : all_invariants()) infos.push_back(each->info);
    return infos;
}

bool SceneReport::holds() const {
    return std::none_of(results.begin(), results.end(),
                        [](const InvariantResult& result) { return result.outcome == InvariantState::violated; });
}

Result<SceneReport> check_invariants(const std::string& text, const std::string& path,
                                     const InvariantOptions& options) {
    std::vector<std::string> names;
    for (const Invariant* each : all_invariants()) names.emplace_back(each->info.name);
    for (const std::string& name : options.only)
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            std::string list;
            for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
            return error_at({}, "unknown invariant '" + name + "'; expected one of: " + list, near_miss(name, names));
        }
    SceneReport report;
    const auto test = SceneUnderTest::make(text, path, options);
    if (!test) {
        report.refused = test.error().to_string();
        if (test.error().message.empty())
            report.results.push_back({"error", InvariantState::violated, 1, 0, "rejected without an error message"});
        return report;
    }
    for (const Invariant* each : all_invariants()) {
        const bool named = std::find(options.only.begin(), options.only.end(), each->info.name) != options.only.end();
        if (options.only.empty() ? each->info.of_means && !options.means : !named) continue;
        if (each->info.of_ordinary && !options.ordinary) continue;
        const Measured measured = each->check(*test);
        InvariantResult result{std::string(each->info.name), InvariantState::skipped, measured.value, measured.bound,
                               measured.note};
        // NaN violates every bound.
        if (measured.applies)
            result.outcome = measured.value <= measured.bound ? InvariantState::holds : InvariantState::violated;
        report.results.push_back(std::move(result));
    }
    return report;
}

}  // namespace raylex::experiments
