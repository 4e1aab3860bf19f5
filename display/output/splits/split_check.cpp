#include "display/output/splits/split_check.h"

#include <algorithm>

#include "display/output/reader/exr_layers.h"
#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/layer_error.h"
#include "display/output/splits/split_sum.h"
#include "display/output/splits/stored_precision.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

// Sums in raylex's own renders are exact, and rounded once when they are stored. `raylex mix` and `raylex denoise` add
// attributes to images of other renderers too.
double working_unit(const ExrImage& image) {
    const bool ours = std::any_of(image.attributes.begin(), image.attributes.end(), [](const auto& attribute) {
        const std::string_view name = attribute.first;
        if (name.starts_with("raylex/mix") || name == "raylex/denoised") return false;
        return name.starts_with("raylex/") || name.starts_with("lpe/");
    });
    return ours ? 0.0 : 0x1p-24;
}

double cancelled(const ExrImage& image) {
    return cancelled_unit * light_magnitude_of(image.attributes);
}

}  // namespace

bool glob_match(std::string_view pattern, std::string_view name) {
    std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            resume = n;
        } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
            ++p;
            ++n;
        } else if (star != std::string_view::npos) {  // extend the last * by one character
            p = star + 1;
            n = ++resume;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

Result<SplitResult> check_split(const ExrImage& image, const std::string& of, const std::vector<std::string>& sums,
                                const Allowance& allowance) {
    Result<const ImageLayer*> whole = image.require_layer(of);
    if (!whole) return std::move(whole).error();
    Result<LayerSum> sum = parse_sum(image, **whole, sums);
    if (!sum) return std::move(sum).error();
    return check_sum(image, **whole, *sum, {working_unit(image), cancelled(image), allowance});
}

Result<std::vector<SplitResult>> check_declared_splits(const ExrImage& image, const Allowance& allowance) {
    std::vector<SplitResult> results;
    for (const PartitionDeclaration& partition : image.partitions) {
        const auto located = [&partition](Error error) {
            error.message = "partition '" + partition.name + "': " + error.message;
            return error;
        };
        if (partition.layers.empty())
            return located(error_at({image.path, 0, 0},
                                    "the header does not list its layers; expected \"beauty = first + second + ...\""));
        Result<const ImageLayer*> whole = image.require_layer(partition.of);
        if (!whole) return located(std::move(whole).error());
        std::vector<const ImageLayer*> layers;
        for (const std::string& name : partition.layers) {
            Result<const ImageLayer*> layer = image.require_layer(name);
            if (!layer) return located(std::move(layer).error());
            layers.push_back(*layer);
        }
        Result<SplitResult> result =
            check_sum(image, **whole, sum_of_layers(layers), {0.0, cancelled(image), allowance});
        if (!result) return located(std::move(result).error());
        result->partition = partition.name;
        results.push_back(std::move(*result));
    }
    return results;
}

namespace {

/// Runs check(image) on all bands and combines the results.
template <class Check>
Result<std::vector<SplitResult>> by_bands(const ExrBands& file, Check check) {
    constexpr std::uint64_t band_bytes = std::uint64_t{256} << 20;
    std::vector<SplitResult> all;
    for (const RowRange& rows : file.bands(band_bytes)) {
        Result<ExrImage> image = file.read(rows);
        if (!image) return std::move(image).error();
        Result<std::vector<SplitResult>> results = check(*image);
        if (!results) return std::move(results).error();
        if (rows.first == 0) all = *std::move(results);
        else
            for (std::size_t i = 0; i < all.size(); ++i) add_rows(all[i], (*results)[i], rows.first);
    }
    return all;
}

}  // namespace

Result<SplitResult> check_split(const ExrBands& file, const std::string& of, const std::vector<std::string>& sums,
                                const Allowance& allowance) {
    auto results = by_bands(file, [&](const ExrImage& image) -> Result<std::vector<SplitResult>> {
        Result<SplitResult> result = check_split(image, of, sums, allowance);
        if (!result) return std::move(result).error();
        return std::vector<SplitResult>{*std::move(result)};
    });
    if (!results) return std::move(results).error();
    return std::move(results->front());
}

Result<std::vector<SplitResult>> check_declared_splits(const ExrBands& file, const Allowance& allowance) {
    return by_bands(file, [&](const ExrImage& image) { return check_declared_splits(image, allowance); });
}

}  // namespace raylex::display
