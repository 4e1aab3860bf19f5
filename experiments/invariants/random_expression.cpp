#include "experiments/invariants/random_expression.h"

#include "experiments/invariants/random.h"

namespace raylex::experiments {

std::string random_expression(std::uint64_t seed) {
    Random random(seed ^ 0x5eed);
    const std::array<const char*, 12> events{"D",    "S",    "G",       "V", ".",    "<RD>",
                                             "<TS>", "<TG>", "<R[GS]>", "R", "[^D]", "<.[DG]>"};
    const std::array<const char*, 8> repeats{"", "", "", "*", "+", "?", "{2}", "{1,3}"};
    const auto sequence = [&] {
        std::string text;
        for (std::size_t i = 1 + random.below(3); i > 0; --i) (text += random.one_of(events)) += random.one_of(repeats);
        return text;
    };
    std::string text = "C(" + sequence() + ")";
    if (random.chance(0.4)) text += "(" + sequence() + "|(" + sequence() + "))" + random.one_of(repeats);
    if (random.chance(0.2)) text = "(" + text + ".*&C(" + sequence() + ").*)";
    return text + random.one_of(std::array{"L", "[LO]", "O", "B", ".*[LO]"});
}

}  // namespace raylex::experiments
