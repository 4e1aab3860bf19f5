// Conversion of channels from Python, and of paths to Python.
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

/// A channel from raylex.lpe: (name, expression, dialect).
using ChannelTuple = std::tuple<std::string, std::string, std::string>;

lpe::Dialect dialect_of(const std::string& name);
/// Returns a channel source. Errors refer to the expression by the channel's name.
lpe::ChannelSource source_of(const ChannelTuple& channel);
std::vector<lpe::ChannelSource> sources_of(const std::vector<ChannelTuple>& channels);

/// Returns None for an empty path.
std::optional<lpe::Witness> path_of(lpe::Witness witness);
/// Returns the names of these channels.
std::vector<std::string> names_of(const std::vector<lpe::ChannelSource>& channels,
                                  const std::vector<std::size_t>& indices);
/// Parses "C,- R,D L,-".
lpe::Witness path_from_text(const std::string& text);

}  // namespace raylex::python
