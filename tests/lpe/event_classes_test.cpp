#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "lpe/match.h"
#include "lpe/program.h"

namespace raylex::lpe {

TEST_CASE("labels after an empty one do not hide the event from expressions that do not test them") {
    // Objects without a label whose lobes have one, together with channels that name an object.
    const std::vector<std::string> expressions{
        "C.*", "C<RD>[<L.>O]", "C<RD'floor'>.*", "C<.S'pass*'>*((U2L)|O)", "C<.S[^'floor']>L", "C<RD.'diffuse'>L"};
    std::vector<ChannelSource> channels;
    for (const std::string& expression : expressions) { channels.push_back({"c", expression}); }
    const auto program = Program::compile(channels);
    REQUIRE(program.ok());
    for (const char* path :
         {"C,- R,D,,diffuse L,-", "C,- R,S,,glass L,-", "C,- R,S2 L,-", "C,- R,D,,other L,-,key", "C,- R,D,floor,x L,-",
          "C,- T,S,passthru,x U2,-,,albedo L,-", "C,- R,G,,coat R,D,,diffuse B,-,,more"}) {
        const auto events = parse_events(path);
        REQUIRE(events.ok());
        std::vector<State> state(program->starts().begin(), program->starts().end());
        for (const Event& event : *events) {
            program->view().advance(state.data(), program->classify(event), state.data());
        }
        std::vector<bool> accepted(expressions.size());
        program->view().for_each_accepted(state.data(), [&](std::uint16_t channel) { accepted[channel] = true; });
        for (std::size_t k = 0; k < expressions.size(); ++k) {
            const auto matches = match(expressions[k], *events, Dialect::renderman);
            REQUIRE(matches.ok());
            CAPTURE(path, expressions[k]);
            CHECK(accepted[k] == *matches);
        }
    }
}

}  // namespace raylex::lpe
