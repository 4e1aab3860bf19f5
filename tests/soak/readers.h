// Every kind of file that raylex reads: small sound examples, and a way to read one as the program does.
#pragma once

#include <string>
#include <vector>

namespace raylex::test {

struct InputKind {
    std::string name;
    std::string extension;                  ///< with its dot
    std::vector<std::string> seeds;         ///< contents of sound files
    bool (*read)(const std::string& path);  ///< whether it was accepted
};

/// `folder` takes the files that libraries must write for the examples; what scenes name stands there too.
std::vector<InputKind> input_kinds(const std::string& folder);

}  // namespace raylex::test
