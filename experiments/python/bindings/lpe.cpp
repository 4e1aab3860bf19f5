// raylex.lpe: events, paths, the words for proofs, channel files.
#include <algorithm>
#include <array>

#include "experiments/job/channels/channel_set.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job.h"
#include "experiments/python/bindings/lpe_types.h"
#include "lpe/match.h"
#include "lpe/path_strings.h"
#include "lpe/shipped.h"

namespace raylex::python {

using namespace pybind11::literals;

lpe::Dialect dialect_of(const std::string& name) {
    return take(experiments::parse_dialect(name, {"dialect", 0, 0}));
}

lpe::ChannelSource source_of(const ChannelTuple& channel) {
    lpe::ChannelSource source;
    source.name = std::get<0>(channel);
    source.expression = std::get<1>(channel);
    source.dialect = dialect_of(std::get<2>(channel));
    source.origin = source.name.empty() ? "expression" : "channel '" + source.name + "'";
    return source;
}

std::vector<lpe::ChannelSource> sources_of(const std::vector<ChannelTuple>& channels) {
    std::vector<lpe::ChannelSource> sources;
    std::transform(channels.begin(), channels.end(), std::back_inserter(sources), source_of);
    return sources;
}

std::optional<lpe::Witness> path_of(lpe::Witness witness) {
    if (witness.events.empty()) return std::nullopt;
    return witness;
}

std::vector<std::string> names_of(const std::vector<lpe::ChannelSource>& channels,
                                  const std::vector<std::size_t>& indices) {
    std::vector<std::string> names;
    for (const std::size_t index : indices) names.push_back(channels[index].name);
    return names;
}

lpe::Witness path_from_text(const std::string& text) {
    lpe::Witness path;
    path.events = take(lpe::parse_events(text));
    path.text = lpe::to_text(path.events);
    path.sentence = lpe::to_sentence(path.events);
    return path;
}

namespace {

std::string type_letter(const lpe::Event& event) {
    constexpr std::array<const char*, 8> letters{"C", "R", "T", "V", "L", "B", "O", "U"};
    const std::string letter = letters[static_cast<std::size_t>(event.type)];
    return event.type == lpe::EventType::user ? letter + std::to_string(event.lobe_number) : letter;
}

std::string scatter_letter(const lpe::Event& event) {
    constexpr std::array<const char*, 5> letters{"", "D", "G", "S", "s"};
    const std::string letter = letters[static_cast<std::size_t>(event.scatter)];
    return letter.empty() || event.lobe_number == 0 ? letter : letter + std::to_string(event.lobe_number);
}

void add_events(py::module_& module) {
    py::class_<lpe::Event>(module, "Event", "One event of a light path.")
        .def_property_readonly("type", type_letter, "'C', 'R', 'T', 'V', 'L', 'B', 'O' or 'U1' to 'U12'")
        .def_property_readonly("scatter", scatter_letter,
                               "'D', 'G' or 'S', with a lobe number if there is one; 's'; ''")
        .def_property_readonly(
            "labels", [](const lpe::Event& event) { return py::tuple(py::cast(event.labels)); },
            "(object, lobe) of a scattering event, (light group,) of a light; '' for none")
        .def("__str__", [](const lpe::Event& event) { return lpe::to_text(event); })
        .def("__repr__", [](const lpe::Event& event) { return "Event('" + lpe::to_text(event) + "')"; })
        .def(
            "__eq__", [](const lpe::Event& a, const lpe::Event& b) { return a == b; }, py::is_operator());
    py::class_<lpe::Witness>(module, "Path", "A light path: camera first, light last.")
        .def(py::init(&path_from_text), "text"_a, "Parses 'C,- R,D,floor L,-,key'.")
        .def_readonly("events", &lpe::Witness::events, "list of Event")
        .def_readonly("text", &lpe::Witness::text, "'C,- R,D,floor L,-,key', as `raylex lpe match` reads it")
        .def_readonly("sentence", &lpe::Witness::sentence, "the path in words")
        .def("__len__", [](const lpe::Witness& path) { return path.events.size(); })
        .def("__str__", [](const lpe::Witness& path) { return path.text; })
        .def("__repr__", [](const lpe::Witness& path) { return "Path('" + path.text + "')  # " + path.sentence; })
        .def(
            "__eq__", [](const lpe::Witness& a, const lpe::Witness& b) { return a.events == b.events; },
            py::is_operator());
}

void add_words(py::module_& module) {
    using Labels = std::optional<std::vector<std::string>>;
    py::class_<lpe::PathStrings>(module, "Words",
                                 "The set of light paths for proofs. By default every path that any scene can "
                                 "produce.")
        .def(py::init([](bool volume, bool straight, bool background, bool emission, bool unlabelled_lights,
                         Labels light_groups, Labels object_labels, std::optional<int> max_depth) {
                 lpe::PathStrings words;
                 words.volume = volume;
                 words.straight = straight;
                 words.background = background;
                 words.emission = emission;
                 words.unlabelled_lights = unlabelled_lights;
                 words.light_groups = std::move(light_groups);
                 words.object_labels = std::move(object_labels);
                 words.max_depth = max_depth;
                 return words;
             }),
             py::kw_only(), "volume"_a = true, "straight"_a = true, "background"_a = true, "emission"_a = true,
             "unlabelled_lights"_a = true, "light_groups"_a = py::none(), "object_labels"_a = py::none(),
             "max_depth"_a = py::none())
        .def_readonly("volume", &lpe::PathStrings::volume)
        .def_readonly("background", &lpe::PathStrings::background)
        .def_readonly("emission", &lpe::PathStrings::emission)
        .def_readonly("light_groups", &lpe::PathStrings::light_groups)
        .def_readonly("object_labels", &lpe::PathStrings::object_labels)
        .def_readonly("max_depth", &lpe::PathStrings::max_depth)
        .def_property_readonly(
            "scattering",
            [](const lpe::PathStrings& words) {
                return words.alphabet ? py::cast(words.alphabet->scattering) : py::object(py::none());
            },
            "the scattering events of a scene, a list of Event; None without a scene")
        .def_property_readonly(
            "terminals",
            [](const lpe::PathStrings& words) {
                return words.alphabet ? py::cast(words.alphabet->terminals) : py::object(py::none());
            },
            "its lights, background and emission");
    module.def(
        "_words_of_file",
        [](const std::string& path) {
            return unlocked([&] { return take(experiments::read_scene_path_strings(path)).words; });
        },
        "path"_a);
}

std::vector<ChannelTuple> tuples_of(const std::vector<lpe::ChannelSource>& sources) {
    std::vector<ChannelTuple> channels;
    for (const lpe::ChannelSource& source : sources)
        channels.emplace_back(source.name, source.expression,
                              source.dialect == lpe::Dialect::osl ? "osl" : "renderman");
    return channels;
}

}  // namespace

void add_lpe(py::module_& module) {
    add_events(module);
    add_words(module);
    module.def(
        "_read_channels",
        [](const std::string& path, const std::string& format, const std::string& dialect) {
            const auto set = take(experiments::read_channel_files({path}, format, dialect_of(dialect)));
            std::vector<std::string> warnings = set.file.warnings;
            auto channels = tuples_of(take(experiments::expanded_channels(set, warnings)));
            return std::pair(std::move(channels), std::move(warnings));
        },
        "path"_a, "format"_a, "dialect"_a);
    module.def(
        "_shipped",
        [](const std::string& dialect) {
            std::vector<std::pair<std::string, std::string>> channels;
            for (const lpe::NamedExpression& each : lpe::shipped_partition(dialect_of(dialect)))
                channels.emplace_back(each.name, each.expression);
            return channels;
        },
        "dialect"_a);
    module.def(
        "_match",
        [](const ChannelTuple& channel, const lpe::Witness& path) {
            return take(lpe::match(std::get<1>(channel), path.events, dialect_of(std::get<2>(channel))));
        },
        "channel"_a, "path"_a);
}

}  // namespace raylex::python
