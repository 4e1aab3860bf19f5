// Channels as Python hands them over, and paths as it gets them back.
#pragma once

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "experiments/python/bindings/bindings.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/program.h"

namespace raylex::python {

/// (name, expression, dialect), as raylex.lpe makes them of whatever it is given.
using ChannelTuple = std::tuple<std::string, std::string, std::string>;

lpe::Dialect dialect_of(const std::string& name);
/// Errors point into the expression by the channel's name.
lpe::ChannelSource source_of(const ChannelTuple& channel);
std::vector<lpe::ChannelSource> sources_of(const std::vector<ChannelTuple>& channels);

/// None where there is no path.
std::optional<lpe::Witness> path_of(lpe::Witness witness);
/// The names of these channels.
std::vector<std::string> names_of(const std::vector<lpe::ChannelSource>& channels,
                                  const std::vector<std::size_t>& indices);
/// Reads "C,- R,D L,-".
lpe::Witness path_from_text(const std::string& text);

}  // namespace raylex::python
