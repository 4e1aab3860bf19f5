// An expression explained to the person who wrote it: what it means in English, piece by piece, what else is the same,
// which paths it accepts, and what it leaves out that one might expect in it.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/path_words.h"
#include "lpe/program.h"
#include "lpe/result.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct Explanation {
    Dialect dialect = Dialect::renderman;
    std::string expression;  ///< the text that the pieces are of: names replaced by what they stand for
    std::string sentence;    ///< "From the camera, one diffuse reflection, ending at a light."
    std::vector<Piece> pieces;
    std::vector<std::pair<std::string, std::string>> prefixes;  ///< name and effect on what is splatted
    std::vector<Witness> samples;       ///< paths it accepts, the shortest first; none when it can never match
    bool beauty = false;                ///< by meaning, in W, without prefixes
    std::vector<std::string> same_as;   ///< "It is the beauty.", "It is the shipped channel 'directDiffuse'."
    std::vector<std::string> notes;     ///< what it never matches, and how letters were taken
    std::vector<std::string> warnings;  ///< readings that differ, pieces that can never match, look-alike letters
};

/// Errors: the expression does not parse or is too large.
Result<Explanation> explain(const ChannelSource& channel, const Words& words = {});

}  // namespace raylex::lpe
