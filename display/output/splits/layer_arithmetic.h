// "(DiffDir + DiffInd) * DiffCol, Emit, Env": sums of layers as people write them.
//
//   sum     = item, item, ...            items are added
//   item    = layer | glob | expression
//   glob    = a name with * or ?; stands alone, for the sum of what it matches; a layer that several globs or names
//   match
//             counts once
//   expression with + - * ( ); a layer in 'quotes' or "quotes" may hold any character; without quotes the longest name
//             that fits is taken, so that names with spaces or - work where it is clear
//
// A * is a glob's where the item, read as a glob, matches a layer, else it multiplies.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// How messages call a layer: the nameless one is the beauty.
[[nodiscard]] std::string name_of(const ImageLayer& layer);

/// One step in postfix order.
struct SumStep {
    enum class Kind : std::uint8_t {
        layer,  ///< push a layer
        add,    ///< the last two
        subtract,
        multiply,
        negate,  ///< the last one
        rounded  ///< the last one came from `count` additions, each rounded by whoever made them
    };
    Kind kind = Kind::layer;
    const ImageLayer* layer = nullptr;
    int count = 0;
};

struct LayerSum {
    std::vector<SumStep> steps;
    std::vector<const ImageLayer*> layers;       ///< each once, in order of appearance
    int additions = 0, products = 0, depth = 0;  ///< depth: values that wait at once
};

/// The text of one or several --sum. Errors point at the column: unknown layers with near misses, `of` itself, syntax,
/// nothing between two commas, a sum of nothing. Names without prefix mean the layer beside `of`.
Result<LayerSum> parse_sum(const ExrImage& image, const ImageLayer& of, const std::vector<std::string>& texts);
/// The plain sum of `layers`.
LayerSum sum_of_layers(const std::vector<const ImageLayer*>& layers);

}  // namespace raylex::display
