// Explains an expression to its author: its meaning in English, the meaning of each piece, equivalent expressions,
// sample paths, and paths that it omits although people often expect them.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/path_words.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct Explanation {
    Dialect dialect = Dialect::renderman;
    std::string expression;  ///< the text that the pieces refer to, with names replaced by their definitions
    std::string sentence;    ///< "From the camera, one diffuse reflection, ending at a light."
    std::vector<Piece> pieces;
    std::vector<std::pair<std::string, std::string>> prefixes;  ///< name and effect on what is splatted
    std::vector<Witness> samples;       ///< accepted paths, shortest first; empty when the expression can never match
    bool beauty = false;                ///< the expression accepts exactly W, and has no prefixes
    std::vector<std::string> same_as;   ///< "It is the beauty.", "It is the shipped channel 'directDiffuse'."
    std::vector<std::string> notes;     ///< paths that it never matches, and how its letters were read
    std::vector<std::string> warnings;  ///< ambiguous readings, pieces that can never match, look-alike letters
};

/// Errors: the expression does not parse or is too large.
Result<Explanation> explain(const ChannelSource& channel, const PathStrings& words = {});

}  // namespace raylex::lpe
