#include "experiments/invariants/checking_process.h"

#include <sys/resource.h>

#include "display/services/parameters.h"
#include "experiments/study/run/processes/messages.h"

namespace raylex::experiments {

RAYLEX_JSON_FIELDS(InvariantResult, invariant, outcome, measured, bound, note)
RAYLEX_JSON_FIELDS(SceneReport, refused, results)
RAYLEX_JSON_FIELDS(InvariantOptions, seed, only, means, ordinary, most_pixels, most_samples, replicates,
                   samples_of_means)

namespace {

std::string answer_check(const std::string& request, const std::string& path) {
    limit_checking_process();
    const Message requested = unpacked(request);
    const auto report = check_invariants(requested.at(0), path, requested.at(1).get<InvariantOptions>());
    return packed(report ? Message(*report) : Message(report.error().to_string()));
}

}  // namespace

void limit_checking_process() {
    const rlimit core{0, 0};
    setrlimit(RLIMIT_CORE, &core);
#ifndef __SANITIZE_ADDRESS__  // the sanitizer reserves terabytes of address space
    constexpr rlim_t bytes = rlim_t{3} << 30;
    const rlimit memory{bytes, bytes};
    setrlimit(RLIMIT_AS, &memory);
#endif
}

CheckingProcess::CheckingProcess(std::string path, double timeout_seconds)
    : timeout_seconds_(timeout_seconds), process_([path = std::move(path)] {
          return [path](const std::string& request, const Tell&) { return answer_check(request, path); };
      }) {}

Result<SceneReport> CheckingProcess::check(const std::string& text, const InvariantOptions& options,
                                           const std::atomic<bool>* stop) {
    const auto answer = process_.ask({packed(Message::array({text, options})), timeout_seconds_, stop, 1, {}});
    if (!answer) return answer.error();
    if (!answer->death.empty()) return SceneReport{{}, {{death_result, InvariantState::violated, 1, 0, answer->death}}};
    const Message content = unpacked(answer->content);
    if (content.is_string()) return error_at({}, content.get<std::string>());
    return content.get<SceneReport>();
}

}  // namespace raylex::experiments
