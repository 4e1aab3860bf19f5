#include "transport/scene/sampler.h"

#include <bit>

namespace raylex::transport {
namespace {

const char* name_of(SamplerKind kind) {
    return kind == SamplerKind::sobol ? "sobol" : kind == SamplerKind::zsobol ? "zsobol" : "independent";
}

Result<SamplerChoice> read_choice(const SceneEntity& entity, SamplerKind kind, bool another_sequence) {
    SamplerChoice choice;
    choice.kind = kind;
    choice.name = name_of(kind);
    auto samples = entity.parameters.integer_or("pixelsamples", 16);
    if (!samples) return samples.error();
    if (*samples < 1)
        return error_at(entity.location, "'pixelsamples' is " + std::to_string(*samples) + "; expected at least 1");
    choice.samples_per_pixel = static_cast<std::uint64_t>(*samples);
    auto seed = entity.parameters.integer_or("seed", 0);
    if (!seed) return seed.error();
    choice.seed = static_cast<std::uint64_t>(*seed);
    choice.stands_in = another_sequence;
    return choice;
}

/// Reads a zsobol sampler. The settings of a job (`spp`, shard, error or time limit) have no influence, since they
/// would change the samples.
Result<SamplerChoice> read_arranged(const SceneEntity& entity) {
    auto choice = read_choice(entity, SamplerKind::zsobol, false);
    if (!choice) return choice;
    auto arranged = entity.parameters.integer_or("arranged", static_cast<std::int64_t>(choice->samples_per_pixel));
    if (!arranged) return arranged.error();
    if (*arranged < 1 || *arranged > std::int64_t{1} << 31)
        return error_at(entity.location, "'arranged' is " + std::to_string(*arranged) + "; expected 1 to 2^31");
    choice->arrangement_bits = static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(*arranged) - 1));
    choice->name += " arranged by " + std::to_string(std::uint64_t{1} << choice->arrangement_bits);
    return choice;
}

Result<SamplerChoice> read_stratified(const SceneEntity& entity) {
    auto choice = read_choice(entity, SamplerKind::sobol, true);
    if (!choice) return choice;
    auto x = entity.parameters.integer_or("xsamples", 4);
    if (!x) return x.error();
    auto y = entity.parameters.integer_or("ysamples", 4);
    if (!y) return y.error();
    if (*x < 1 || *y < 1) return error_at(entity.location, "'xsamples' and 'ysamples' must be at least 1");
    choice->samples_per_pixel = static_cast<std::uint64_t>(*x) * static_cast<std::uint64_t>(*y);
    return choice;
}

Registry<SamplerFactory> make_registry() {
    const std::vector<ParameterDescription> parameters = {
        {"pixelsamples", ParameterType::integer, "16", "samples per pixel, at least 1; powers of two balance best"},
        {"seed", ParameterType::integer, "0", "added to the render's seed"}};
    Registry<SamplerFactory> registry("sampler");
    const auto add = [&](const char* name, const char* help, SamplerKind kind, bool another) {
        registry.add({name, help, parameters,
                      [kind, another](const SceneEntity& entity) { return read_choice(entity, kind, another); }});
    };
    add("sobol", "Owen-scrambled Sobol' points, padded in pairs of dimensions", SamplerKind::sobol, false);
    add("paddedsobol", "another name for sobol", SamplerKind::sobol, false);
    add("independent", "independent uniform numbers", SamplerKind::independent, false);
    std::vector<ParameterDescription> of_arranged = parameters;
    of_arranged.push_back({"arranged", ParameterType::integer, "pixelsamples",
                           "samples of a pixel that are arranged together, rounded up to a power of two"});
    registry.add({"zsobol",
                  "sobol, arranged in screen space: with 'arranged' samples per pixel the error is blue noise",
                  of_arranged, read_arranged});
    add("halton", "rendered with sobol", SamplerKind::sobol, true);
    add("pmj02bn", "rendered with sobol", SamplerKind::sobol, true);
    registry.add({"stratified",
                  "rendered with sobol, xsamples * ysamples per pixel",
                  {{"xsamples", ParameterType::integer, "4", "strata in x"},
                   {"ysamples", ParameterType::integer, "4", "strata in y"},
                   {"seed", ParameterType::integer, "0", "added to the render's seed"}},
                  read_stratified});
    return registry;
}

}  // namespace

Registry<SamplerFactory>& sampler_registry() {
    static Registry<SamplerFactory> registry = make_registry();
    return registry;
}

Result<SamplerChoice> choose_sampler(const SceneEntity& entity) {
    if (entity.type.empty()) {
        SamplerChoice choice;
        choice.name = "sobol";
        return choice;
    }
    auto entry = sampler_registry().require(entity.type, entity.location);
    if (!entry) return entry.error();
    return (*entry)->factory(entity);
}

}  // namespace raylex::transport
