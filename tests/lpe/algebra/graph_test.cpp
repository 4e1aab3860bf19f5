// Drawn automata: a graph accepts what its channels match, and its DOT is well-formed.
#include <catch2/catch.hpp>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "lpe/algebra/graphs/graph.h"
#include "lpe/match.h"
#include "lpe/shipped.h"

using namespace raylex::lpe;

namespace {

std::vector<ChannelSource> graph_sources(const std::vector<std::string>& texts, Dialect dialect = Dialect::renderman) {
    std::vector<ChannelSource> channels;
    for (const std::string& text : texts) {
        channels.emplace_back();
        channels.back().expression = text;
        channels.back().dialect = dialect;
    }
    return channels;
}

/// Words of W of at most four events. Their events match and miss every label and lobe number of the tests.
std::vector<std::vector<Event>> some_path_strings() {
    const std::vector<Event> scattering = *parse_events("R,D R,D,a T,D,a R,G R,S2 T,S T,G,b V,- V,-,a");
    const std::vector<Event> ends = *parse_events("L,- L,-,k B,- B,-,k O,-,k");
    std::vector<std::vector<Event>> prefixes{{Event{}}};
    std::vector<std::vector<Event>> words;
    for (std::size_t i = 0; i < prefixes.size(); ++i) {
        for (const Event& end : ends) {
            words.push_back(prefixes[i]);
            words.back().push_back(end);
        }
        for (std::size_t k = 0; k < scattering.size() && prefixes[i].size() < 3; ++k) {
            prefixes.push_back(prefixes[i]);
            prefixes.back().push_back(scattering[k]);
        }
    }
    return words;
}

/// The channels of the state to which the events of `path` lead. Each label must be an expression of the dialect.
std::vector<std::size_t> accepted_by(const Graph& graph, const std::vector<Event>& path, Dialect dialect) {
    std::size_t state = 0;
    for (const Event& event : path) {
        std::optional<std::size_t> next;
        for (const GraphEdge& edge : graph.edges) {
            const bool fits =
                edge.from == state && std::any_of(edge.items.begin(), edge.items.end(), [&](const std::string& item) {
                    const auto answer = match(item, std::vector<Event>{event}, dialect);
                    REQUIRE(answer);
                    return *answer;
                });
            if (fits) {
                CHECK_FALSE(next);  // deterministic
                next = edge.to;
            }
        }
        if (!next) { return {}; }
        state = *next;
    }
    return graph.states[state].accepts;
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) { ++found; }
    return found;
}

}  // namespace

TEST_CASE("following a graph by its labels accepts what the channels accept", "[gate]") {
    const std::vector<std::vector<std::string>> sets{{"CD*L", "C.*S.*"},
                                                     {"C<RD'a'>.*", "C.*<L.'k'>"},
                                                     {"C[^D]*O", "C.* - CD.*", "C<T.>B"},
                                                     {"C<R[DG]>+<L.[^'k']>", "CS2.*"}};
    for (const auto& set : sets) {
        const std::vector<ChannelSource> channels = graph_sources(set);
        const auto graph = graph_of(channels);
        REQUIRE(graph);
        std::size_t seen = 0;
        for (const std::vector<Event>& path : some_path_strings()) {
            if (path.size() == 4 && ++seen % 5 != 0) {
                continue;  // each label is compiled, so a fifth of the long words has to do
            }
            std::vector<std::size_t> expected;
            for (std::size_t k = 0; k < channels.size(); ++k) {
                if (*match(channels[k].expression, path, Dialect::renderman)) { expected.push_back(k); }
            }
            CAPTURE(set, to_text(path));
            CHECK(accepted_by(*graph, path, Dialect::renderman) == expected);
        }
    }
}

TEST_CASE("osl graphs are labelled in osl") {
    const auto graph = graph_of(graph_sources({"C<RD>[GS]*L", "C.*B"}, Dialect::osl));
    REQUIRE(graph);
    for (const char* text : {"C,- R,D L,-", "C,- R,D T,G R,S L,-", "C,- B,-", "C,- T,s B,-", "C,- V,- L,-"}) {
        const std::vector<Event> path = *parse_events(text);
        std::vector<std::size_t> expected;
        if (*match("C<RD>[GS]*L", path, Dialect::osl)) expected.push_back(0);
        if (*match("C.*B", path, Dialect::osl)) expected.push_back(1);
        CAPTURE(text);
        CHECK(accepted_by(*graph, path, Dialect::osl) == expected);
    }
}

TEST_CASE("every state of the shipped partition's graph leads on or accepts one channel") {
    std::vector<ChannelSource> channels;
    for (const NamedExpression& entry : shipped_partition()) {
        channels.emplace_back();
        channels.back().name = std::string(entry.name);
        channels.back().expression = std::string(entry.expression);
    }
    const auto graph = graph_of(channels);
    REQUIRE(graph);
    std::vector<bool> leads_on(graph->states.size(), false);
    for (const GraphEdge& edge : graph->edges) {
        leads_on[edge.from] = true;
        CHECK_FALSE(edge.items.empty());
    }
    for (std::size_t k = 0; k < graph->states.size(); ++k) {
        CHECK((leads_on[k] || graph->states[k].accepts.size() == 1));
    }
    CHECK(count(to_dot(*graph), " -> ") == graph->edges.size() + 1);  // and the arrow to the start
    CHECK(to_dot(*graph).find("directDiffuse") != std::string::npos);
}

TEST_CASE("text in DOT is quoted, and long labels are broken") {
    const auto quoted = graph_of(graph_sources({"C<RD'a\"b'>L"}));
    REQUIRE(quoted);
    CHECK(to_dot(*quoted).find("<RD'a\\\"b'>") != std::string::npos);
    const auto wide = graph_of(graph_sources({"C[<RD'one'><RS'two'><TD'three'><TS'four'>V]B"}));
    REQUIRE(wide);
    CHECK(to_dot(*wide).find("'>\\n<") != std::string::npos);
}

TEST_CASE("the graph of an empty language has no edge, and a graph that is too large is refused") {
    const auto empty = graph_of(graph_sources({"CLD"}));
    REQUIRE(empty);
    CHECK(empty->states.empty());
    CHECK(to_dot(*empty).find("no path is accepted") != std::string::npos);
    CHECK(to_dot(*empty).find("->") == std::string::npos);
    const auto large = graph_of(graph_sources({"C.*D.{9}L"}));
    REQUIRE_FALSE(large);
    CHECK(large.error().message.find("states") != std::string::npos);
    CHECK_FALSE(graph_of(graph_sources(std::vector<std::string>(33, "CL"))));
}
