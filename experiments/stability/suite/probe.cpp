#include "experiments/stability/probe.h"

namespace raylex::experiments {

double ProbeInput::number(const std::string& name) const {
    const auto found = setting_.numbers.find(name);
    if (found != setting_.numbers.end()) return found->second;
    if (missing_.empty()) missing_ = "number '" + name + "'";
    return 0;
}

double ProbeInput::number(const std::string& name, double fallback) const {
    const auto found = setting_.numbers.find(name);
    return found != setting_.numbers.end() ? found->second : fallback;
}

std::string ProbeInput::word(const std::string& name) const {
    const auto found = setting_.words.find(name);
    if (found != setting_.words.end()) return found->second;
    if (missing_.empty()) missing_ = "word '" + name + "'";
    return {};
}

std::string ProbeInput::word(const std::string& name, const std::string& fallback) const {
    const auto found = setting_.words.find(name);
    return found != setting_.words.end() ? found->second : fallback;
}

Status ProbeInput::status() const {
    if (missing_.empty()) return success();
    return error_at(where_, "the probe needs a " + missing_ + "; expected it in 'with' or 'vary'");
}

Registry<Probe>& probe_registry() {
    static Registry<Probe> registry("probe");
    return registry;
}

}  // namespace raylex::experiments
