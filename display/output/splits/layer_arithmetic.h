// Parses sums of layers in users' notation: "(DiffDir + DiffInd) * DiffCol, Emit, Env".
//
//   sum     = item, item, ...            items are added
//   item    = layer | glob | expression
//   glob    = a name with * or ?, alone in its item; the sum of the layers that it matches; a layer that several
//             globs or names match counts once
//   expression with + - * ( ); a layer in 'quotes' or "quotes" can have any characters; without quotes the longest name
//             that matches is taken, so that names with spaces or - work if they are unambiguous
//
// A * is a wildcard if the item, read as a glob, matches a layer; otherwise it multiplies.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// The name of a layer in messages; the nameless one is named beauty.
[[nodiscard]] std::string name_of(const ImageLayer& layer);

/// One step of an expression in postfix order.
struct SumStep {
    enum class Kind : std::uint8_t {
        layer,  ///< push a layer
        add,    ///< add the last two values
        subtract,
        multiply,
        negate,  ///< negate the last value
        rounded  ///< the last value came from `count` additions, each rounded by the writer of the image
    };
    Kind kind = Kind::layer;
    const ImageLayer* layer = nullptr;
    int count = 0;
};

struct LayerSum {
    std::vector<SumStep> steps;
    std::vector<const ImageLayer*> layers;       ///< each layer once, in order of appearance
    int additions = 0, products = 0, depth = 0;  ///< depth: largest number of values on the stack
};

/// Parses one or several --sum texts. Errors give the column: unknown layers with similar names, `of` itself, syntax,
/// an empty item, an empty sum. Names without prefix denote the layer with the prefix of `of`.
Result<LayerSum> parse_sum(const ExrImage& image, const ImageLayer& of, const std::vector<std::string>& texts);
/// The plain sum of `layers`.
LayerSum sum_of_layers(const std::vector<const ImageLayer*>& layers);

}  // namespace raylex::display
