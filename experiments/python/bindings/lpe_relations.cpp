// raylex.lpe: proofs, and explanations of expressions.
#include "experiments/python/bindings/lpe_types.h"
#include "lpe/algebra/explanation/explain.h"
#include "lpe/algebra/explanation/why_not.h"
#include "lpe/algebra/proofs/overview.h"
#include "lpe/algebra/proofs/paths.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/path_strings.h"

namespace raylex::python {

using namespace pybind11::literals;

namespace {

/// The answer to a question: whether the statement holds, and otherwise a counterexample.
struct Answer {
    bool holds = true;
    std::string result;  ///< of a partition: "partition", "missed", "counted_twice", "outside"
    lpe::Witness witness;
    std::vector<std::string> channels;
    std::string summary;
    std::vector<std::string> warnings;
};

Answer answer_of(lpe::PartitionReport report, const std::vector<lpe::ChannelSource>& sources) {
    constexpr const char* names[] = {"partition", "missed", "counted_twice", "outside"};
    return {report.result == lpe::SplitProof::partition,
            names[static_cast<std::size_t>(report.result)],
            std::move(report.witness),
            names_of(sources, report.channels),
            std::move(report.summary),
            std::move(report.warnings)};
}

Answer answer_of(lpe::DisjointReport report, const std::vector<lpe::ChannelSource>& sources) {
    return {report.disjoint,           report.disjoint ? "disjoint" : "counted_twice",
            std::move(report.witness), names_of(sources, report.channels),
            std::move(report.summary), std::move(report.warnings)};
}

Answer answer_of(lpe::Proof proof, const std::vector<lpe::ChannelSource>& sources, const char* yes, const char* no) {
    return {proof.holds,
            proof.holds ? yes : no,
            std::move(proof.witness),
            names_of(sources, proof.channels),
            std::move(proof.summary),
            std::move(proof.warnings)};
}

Answer check(const std::vector<ChannelTuple>& channels, const std::optional<ChannelTuple>& of, const std::string& what,
             const lpe::PathStrings& words) {
    const std::vector<lpe::ChannelSource> sources = sources_of(channels);
    std::optional<lpe::ChannelSource> whole;
    if (of) whole = source_of(*of);
    if (what == "partition") return answer_of(take(lpe::check_partition(sources, whole, words)), sources);
    if (what == "covers") return answer_of(take(lpe::check_covers(sources, whole, words)), sources, "covers", "missed");
    if (what == "disjoint") {
        if (of) fail("'of' cannot be combined with what='disjoint'; expected what='partition' or 'covers'");
        return answer_of(take(lpe::check_disjoint(sources, words)), sources);
    }
    fail("what is '" + what + "'; expected 'partition', 'disjoint' or 'covers'");
}

py::dict overview(const std::vector<ChannelTuple>& channels, const std::optional<ChannelTuple>& of,
                  const lpe::PathStrings& words) {
    const std::vector<lpe::ChannelSource> sources = sources_of(channels);
    std::optional<lpe::ChannelSource> whole;
    if (of) whole = source_of(*of);
    const lpe::Overview all = unlocked([&] { return take(lpe::look_over(sources, whole, words)); });
    py::list overlaps, holes, outside, empty;
    for (const lpe::SharedPath& each : all.overlaps)
        overlaps.append(py::make_tuple(sources[each.first].name, sources[each.second].name, each.witness));
    for (const lpe::Hole& each : all.holes) holes.append(py::make_tuple(each.kind, each.witness, each.others));
    for (const lpe::OutsidePath& each : all.outside)
        outside.append(py::make_tuple(sources[each.channel].name, each.witness));
    for (const std::size_t each : all.empty) empty.append(sources[each].name);
    return py::dict("overlaps"_a = overlaps, "holes"_a = holes, "outside"_a = outside, "empty"_a = empty,
                    "unknown"_a = all.holes_unknown);
}

void add_answer(py::module_& module) {
    py::class_<Answer>(module, "Check", "The answer to a question about expressions: a proof, or a counterexample.")
        .def_readonly("holds", &Answer::holds, "True if the statement is proved")
        .def_readonly("verdict", &Answer::result, "'partition', 'missed', 'counted_twice', 'outside', ...")
        .def_property_readonly(
            "counterexample", [](const Answer& answer) { return path_of(answer.witness); },
            "the shortest Path as counterexample; None if the statement holds")
        .def_readonly("channels", &Answer::channels, "names of the channels that accept the counterexample")
        .def_readonly("summary", &Answer::summary, "one sentence")
        .def_readonly("warnings", &Answer::warnings, "notes on unexpected interpretations of the expressions")
        .def("__bool__", [](const Answer& answer) { return answer.holds; })
        .def("__repr__", [](const Answer& answer) {
            return "Check(" + std::string(answer.holds ? "holds" : "does not hold") + ": " + answer.summary + ")";
        });
}

void add_proofs(py::module_& module) {
    module.def("_check", &check, "channels"_a, "of"_a, "what"_a, "words"_a, py::call_guard<Unlocked>());
    module.def("_overview", &overview, "channels"_a, "of"_a, "words"_a);
    module.def(
        "_equal",
        [](const std::vector<ChannelTuple>& channels, const lpe::PathStrings& words) {
            const auto sources = sources_of(channels);
            return answer_of(take(lpe::check_equal(sources, words)), sources, "equal", "different");
        },
        "channels"_a, "words"_a, py::call_guard<Unlocked>());
    module.def(
        "_contains",
        [](const ChannelTuple& outer, const ChannelTuple& inner, const lpe::PathStrings& words) {
            const auto sources = sources_of({outer, inner});
            return answer_of(take(lpe::check_contains(sources[0], sources[1], words)), sources, "contains",
                             "does not contain");
        },
        "outer"_a, "inner"_a, "words"_a, py::call_guard<Unlocked>());
    module.def(
        "_empty",
        [](const ChannelTuple& channel, const lpe::PathStrings& words) {
            const auto sources = sources_of({channel});
            return answer_of(take(lpe::check_empty(sources[0], words)), sources, "empty", "not empty");
        },
        "channel"_a, "words"_a, py::call_guard<Unlocked>());
}

lpe::Operation operation_of(const std::string& name) {
    constexpr std::pair<const char*, lpe::Operation> all[] = {{"words", lpe::Operation::words},
                                                              {"complement", lpe::Operation::complement},
                                                              {"intersection", lpe::Operation::intersection},
                                                              {"union", lpe::Operation::united},
                                                              {"difference", lpe::Operation::difference}};
    for (const auto& [known, operation] : all)
        if (name == known) return operation;
    fail("'" + name + "' is not an operation; expected 'words', 'complement', 'intersection', 'union' or 'difference'");
}

void add_path_sets(py::module_& module) {
    py::class_<lpe::PathSet>(module, "PathSet", "Facts about a set of light paths.")
        .def_readonly("samples", &lpe::PathSet::samples, "list of Path, the shortest first")
        .def_readonly("counts", &lpe::PathSet::counts,
                      "number of paths with 0, 1, ... events that the expressions distinguish")
        .def_readonly("longest", &lpe::PathSet::longest,
                      "number of events of the longest path; None if there is no longest")
        .def_readonly("states", &lpe::PathSet::states, "number of states of the minimal automaton")
        .def_readonly("warnings", &lpe::PathSet::warnings)
        .def("__bool__", [](const lpe::PathSet& set) { return !set.empty(); });
    module.def(
        "_paths",
        [](const std::string& operation, const std::vector<ChannelTuple>& channels, const lpe::PathStrings& words,
           std::size_t samples, std::size_t longest_counted) {
            return take(
                lpe::look_at_paths(operation_of(operation), sources_of(channels), words, {samples, longest_counted}));
        },
        "operation"_a, "channels"_a, "words"_a, "samples"_a, "longest_counted"_a, py::call_guard<Unlocked>());
}

void add_explanations(py::module_& module) {
    py::class_<lpe::Explanation>(module, "Explanation", "An expression in words.")
        .def_readonly("expression", &lpe::Explanation::expression, "the expression with names expanded")
        .def_readonly("sentence", &lpe::Explanation::sentence)
        .def_readonly("prefixes", &lpe::Explanation::prefixes, "list of (name, effect)")
        .def_readonly("samples", &lpe::Explanation::samples, "list of Path that it accepts, the shortest first")
        .def_readonly("is_beauty", &lpe::Explanation::beauty, "whether it accepts every path")
        .def_readonly("same_as", &lpe::Explanation::same_as)
        .def_readonly("notes", &lpe::Explanation::notes)
        .def_readonly("warnings", &lpe::Explanation::warnings)
        .def("__str__", [](const lpe::Explanation& explanation) { return explanation.sentence; });
    module.def(
        "_explain",
        [](const ChannelTuple& channel, const lpe::PathStrings& words) {
            return take(lpe::explain(source_of(channel), words));
        },
        "channel"_a, "words"_a, py::call_guard<Unlocked>());
    py::class_<lpe::WhyNot>(module, "WhyNot", "The event where a path fails to match, and the events expected there.")
        .def_readonly("matches", &lpe::WhyNot::matches)
        .def_readonly("live_events", &lpe::WhyNot::live_events,
                      "number of events of the path that begin a matching path")
        .def_readonly("wanted", &lpe::WhyNot::wanted, "what could follow, in words")
        .def_readonly("hint", &lpe::WhyNot::hint)
        .def("__bool__", [](const lpe::WhyNot& why) { return why.matches; });
    module.def(
        "_why_not",
        [](const ChannelTuple& channel, const lpe::Witness& path) {
            return take(lpe::why_not(source_of(channel), path.events));
        },
        "channel"_a, "path"_a, py::call_guard<Unlocked>());
}

}  // namespace

void add_lpe_relations(py::module_& module) {
    add_answer(module);
    add_proofs(module);
    add_path_sets(module);
    add_explanations(module);
}

}  // namespace raylex::python
