#include "display/output/splits/layer_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "display/output/reader/exr_layers.h"
#include "display/output/splits/rebuild.h"
#include "display/output/splits/split_sum.h"
#include "display/output/splits/stored_precision.h"

namespace raylex::display {

namespace {

using Kind = SumStep::Kind;
using LayerPlanes = std::array<const ImagePlane*, 3>;
constexpr std::size_t block = 512;  // pixels at a time: the stack of a sum of fifty layers fits in the cache

// The three components of a layer, or why it cannot be part of a sum of light.
Result<LayerPlanes> summable(const ExrImage& image, const ImageLayer& layer) {
    Error error;
    error.file = image.path;
    const LayerPlanes planes = layer.triple();
    if (planes[0] == nullptr) {
        std::vector<std::string> names;
        for (const ImagePlane& plane : layer.planes) names.push_back(plane.name);
        error.message = "layer '" + name_of(layer) + "' has the channels " + list_names(names) +
                        "; expected R G B, X Y Z or a single one";
        return error;
    }
    for (const ImagePlane* plane : planes) {
        if (plane->stored != StoredType::unsigned_int) continue;
        error.message = "layer '" + name_of(layer) + "' contains unsigned integers (" + plane->name +
                        "); expected light, stored as half or float";
        return error;
    }
    return planes;
}

// Values of a block of pixels with bounds: |value| <= magnitude (the sum of |terms|); the error is at most `rounding`
// from rounding alone, and at most `allowed` with lossy compression.
struct Values {
    std::array<double, block> value, magnitude, rounding, allowed;
    std::array<Open, block> open;  // only if SumOverImage looks for clamped values
};

void load(Values& to, const ImagePlane& plane, const StoredPrecision& precision, bool lossy, std::size_t first,
          std::size_t count) {
    const float* stored = plane.values.data() + first;
    for (std::size_t i = 0; i < count; ++i) {
        const auto value = static_cast<double>(stored[i]);
        to.value[i] = value;
        to.magnitude[i] = std::abs(value);
        to.rounding[i] = precision.unit * std::abs(value) + precision.spacing;
        to.allowed[i] = to.rounding[i];
    }
    if (!lossy || precision.dwa == 0) return;
    for (std::size_t i = 0; i < count; ++i) to.allowed[i] += dwa_change(to.value[i], precision.dwa);
}

// Marks values at the largest number of their type: the true value can be beyond it.
void mark_open(Values& values, const ImagePlane& plane, std::size_t count) {
    const auto largest = static_cast<double>(largest_of(plane.stored));
    for (std::size_t i = 0; i < count; ++i) values.open[i] = open_of(values.value[i], largest);
}

// The directions in which the true product can deviate from a * b. Two factors that can be larger and are not negative
// give a product that can be larger; any other two open factors give a product that can be anything.
Open open_product(double a, Open open_a, double b, Open open_b) {
    constexpr Open anywhere = open_above | open_below;
    if (open_a != 0 && open_b != 0) return a >= 0 && b >= 0 && (open_a | open_b) == open_above ? open_above : anywhere;
    const double known = open_a != 0 ? b : a;
    const auto open = static_cast<Open>(open_a | open_b);
    return known > 0 ? open : known < 0 ? negated(open) : Open{0};
}

void add(Values& a, const Values& b, double sign, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        a.value[i] += sign * b.value[i];
        a.magnitude[i] += b.magnitude[i];
        a.rounding[i] += b.rounding[i];
        a.allowed[i] += b.allowed[i];
    }
}

// (a + e)(b + f) = ab + af + be + ef, rounded once; a product below the smallest float has an error of its spacing.
void multiply(Values& a, const Values& b, double unit, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const double rounded = unit * a.magnitude[i] * b.magnitude[i] + (unit > 0 ? 0x1p-149 : 0);
        a.rounding[i] = a.rounding[i] * (b.magnitude[i] + b.rounding[i]) + a.magnitude[i] * b.rounding[i] + rounded;
        a.allowed[i] = a.allowed[i] * (b.magnitude[i] + b.allowed[i]) + a.magnitude[i] * b.allowed[i] + rounded;
        a.value[i] *= b.value[i];
        a.magnitude[i] *= b.magnitude[i];
    }
}

// Partial sums are at most the sum of magnitudes, in any order.
void round(Values& a, double unit, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        a.rounding[i] += unit * a.magnitude[i];
        a.allowed[i] += unit * a.magnitude[i];
    }
}

// Evaluates one sum over a whole image.
class SumOverImage {
  public:
    SumOverImage(const LayerSum& sum, const SumRules& rules, std::vector<LayerPlanes> planes)
        : sum_(sum), rules_(rules), planes_(std::move(planes)), stack_(static_cast<std::size_t>(sum.depth)) {}

    /// Enables Values::open, because some value is at the largest number of its type.
    void look_for_clamped() { clamped_ = true; }

    /// Evaluates component c of pixels [first, first + count).
    const Values& evaluate(std::size_t c, std::size_t first, std::size_t count) {
        std::size_t top = 0, leaf = 0;  // top: number of values on the stack
        for (const SumStep& step : sum_.steps) {
            switch (step.kind) {
                case Kind::layer: {
                    const ImagePlane& plane = *planes_[leaf++][c];
                    load(stack_[top++], plane, precision_of(plane), !rules_.allowance.instead_of_compression, first,
                         count);
                    if (clamped_) mark_open(stack_[top - 1], plane, count);
                    break;
                }
                case Kind::add:
                case Kind::subtract:
                    --top;
                    for (std::size_t i = 0; clamped_ && i < count; ++i)
                        stack_[top - 1].open[i] |=
                            step.kind == Kind::add ? stack_[top].open[i] : negated(stack_[top].open[i]);
                    add(stack_[top - 1], stack_[top], step.kind == Kind::add ? 1.0 : -1.0, count);
                    break;
                case Kind::multiply:
                    --top;
                    for (std::size_t i = 0; clamped_ && i < count; ++i)
                        stack_[top - 1].open[i] = open_product(stack_[top - 1].value[i], stack_[top - 1].open[i],
                                                               stack_[top].value[i], stack_[top].open[i]);
                    multiply(stack_[top - 1], stack_[top], rules_.working_unit, count);
                    break;
                case Kind::negate:
                    for (std::size_t i = 0; i < count; ++i) stack_[top - 1].value[i] = -stack_[top - 1].value[i];
                    for (std::size_t i = 0; clamped_ && i < count; ++i)
                        stack_[top - 1].open[i] = negated(stack_[top - 1].open[i]);
                    break;
                case Kind::rounded:
                    round(stack_[top - 1], step.count * rules_.working_unit, count);
                    break;
            }
        }
        return stack_.front();
    }

    /// The largest relative error from rounding, relative to the sum of |terms|, except for very small numbers.
    [[nodiscard]] double unit() const {
        std::vector<double> units;
        std::size_t leaf = 0;
        for (const SumStep& step : sum_.steps) {
            if (step.kind == Kind::layer) {
                double unit = 0;
                for (const ImagePlane* plane : planes_[leaf]) unit = std::max(unit, precision_of(*plane).unit);
                units.push_back(unit);
                ++leaf;
            } else if (step.kind == Kind::rounded) {
                units.back() += step.count * rules_.working_unit;
            } else if (step.kind != Kind::negate) {
                const double last = units.back();
                units.pop_back();
                double& unit = units.back();
                unit = step.kind == Kind::multiply ? unit + last + unit * last + rules_.working_unit
                                                   : std::max(unit, last);
            }
        }
        return units.back();
    }

  private:
    const LayerSum& sum_;
    const SumRules& rules_;
    std::vector<LayerPlanes> planes_;  // of the layer steps, in order
    std::vector<Values> stack_;
    bool clamped_ = false;
};

// Explains the bound: "float, 2^-23; half, 2^-10; 8 operations in float, 2^-24 each".
std::string bound_reason(const std::vector<LayerPlanes>& all, const LayerSum& sum, const SumRules& rules) {
    bool half = false, single = false, pxr24 = false;
    for (const LayerPlanes& planes : all)
        for (const ImagePlane* plane : planes) {
            const double unit = precision_of(*plane).unit;
            (unit == 0x1p-10 ? half : unit == 0x1p-15 ? pxr24 : single) = true;
        }
    std::string text;
    const auto name = [&text](bool there, const char* what) {
        if (there) text += (text.empty() ? "" : "; ") + std::string(what);
    };
    name(single, "float, 2^-23");
    name(pxr24, "float packed by PXR24, 2^-15");
    name(half, "half, 2^-10");
    if (rules.cancelled > 0) text += "; samples that cancel, 2^-45 each";
    const int operations = sum.additions + sum.products;
    if (rules.working_unit > 0 && operations > 0)
        text += "; " + std::to_string(operations) + (operations == 1 ? " operation" : " operations") +
                " in float, 2^-24 each";
    return text;
}

// Notes the allowances beyond rounding that were used, and those that would be needed.
void note_allowances(SplitResult& result, const std::vector<LayerPlanes>& all, const Allowance& allowance) {
    std::set<float> levels;
    bool b44 = false;
    for (const LayerPlanes& planes : all)
        for (const ImagePlane* plane : planes) {
            if (plane->loss == PlaneLoss::dwa) levels.insert(plane->dwa_level);
            b44 = b44 || plane->loss == PlaneLoss::b44;
        }
    if (!allowance.instead_of_compression) {
        for (const float level : levels)
            result.allowed_for.push_back("DWA compression of level " +
                                         std::to_string(static_cast<int>(std::lround(level))));
        if (b44) result.unexplained.emplace_back("B44");
    }
    if (allowance.absolute > 0 || allowance.relative > 0) result.allowed_for.push_back(allowance.reason);
}

// Finds the pixels of a block that have a negative value, in all layers and in each.
std::array<bool, block> find_negative(NegativeValues& all, std::map<std::string, NegativeValues>& of_layers, int width,
                                      const std::vector<const ImageLayer*>& layers, std::size_t first,
                                      std::size_t count) {
    std::array<bool, block> found{};
    for (const ImageLayer* layer : layers) {
        std::array<bool, block> here{};
        NegativeValues worst;
        for (const ImagePlane* plane : layer->triple())
            for (std::size_t i = 0; i < count; ++i) {
                const float value = plane->values[first + i];
                if (!(value < 0)) continue;
                here[i] = found[i] = true;
                const auto columns = static_cast<std::size_t>(width);
                if (value < worst.lowest)
                    worst = {0, value, static_cast<int>((first + i) % columns), static_cast<int>((first + i) / columns),
                             name_of(*layer)};
            }
        if (worst.lowest == 0) continue;
        all.add(worst);
        worst.pixels = static_cast<std::size_t>(std::count(here.begin(), here.end(), true));
        of_layers[worst.layer].add(worst);
    }
    all.pixels += static_cast<std::size_t>(std::count(found.begin(), found.end(), true));
    return found;
}

SplitError error_of(const Values& found, const Values& target, std::size_t i, const SumRules& rules, bool negative,
                    bool with_open) {
    const double scale = found.magnitude[i] + target.magnitude[i];
    return {std::abs(found.value[i] - target.value[i]),
            scale,
            found.rounding[i] + target.rounding[i] + rules.cancelled,
            found.allowed[i] + target.allowed[i] + rules.cancelled + rules.allowance.absolute +
                rules.allowance.relative * scale,
            found.value[i],
            target.value[i],
            negative,
            with_open ? static_cast<Open>(found.open[i] | negated(target.open[i])) : Open{0}};
}

// The first layer that is not finite at the pixel that the result reports.
std::string culprit(const SplitResult& result, const ExrImage& image, const std::vector<LayerPlanes>& all,
                    const std::vector<std::string>& names) {
    const auto pixel = static_cast<std::size_t>(result.non_finite_y) * static_cast<std::size_t>(image.width) +
                       static_cast<std::size_t>(result.non_finite_x);
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const ImagePlane* plane : all[i])
            if (!std::isfinite(plane->values[pixel])) return names[i];
    return {};
}

}  // namespace

Result<SplitResult> check_sum(const ExrImage& image, const ImageLayer& of, const LayerSum& sum, const SumRules& rules) {
    Result<LayerPlanes> whole = summable(image, of);
    if (!whole) return std::move(whole).error();
    std::vector<LayerPlanes> planes;
    std::vector<std::string> names;
    for (const SumStep& step : sum.steps) {
        if (step.kind != Kind::layer) continue;
        Result<LayerPlanes> found = summable(image, *step.layer);
        if (!found) return std::move(found).error();
        planes.push_back(*found);
        names.push_back(name_of(*step.layer));
    }
    SumOverImage arithmetic(sum, rules, planes);
    double unit = arithmetic.unit();
    for (const ImagePlane* plane : *whole) unit = std::max(unit, precision_of(*plane).unit);
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    ResultTally tally(image.width, pixels, unit, rules.allowance, true);
    NegativeValues signs;
    std::map<std::string, NegativeValues> signs_of_layers;
    std::vector<const ImageLayer*> layers = sum.layers;
    layers.push_back(&of);
    RebuildTally rebuild(image, of, sum);
    std::vector<bool> clamped;
    planes.push_back(*whole);
    names.push_back(name_of(of));
    for (const LayerPlanes& each : planes)
        for (const ImagePlane* plane : each) mark_clamped(plane->values, plane->stored, clamped);
    if (!clamped.empty()) arithmetic.look_for_clamped();
    Values target;
    std::vector<std::array<SplitError, 3>> errors(block);
    for (std::size_t first = 0; first < pixels; first += block) {
        const std::size_t count = std::min(block, pixels - first);
        const std::array<bool, block> negative =
            find_negative(signs, signs_of_layers, image.width, layers, first, count);
        for (std::size_t c = 0; c < 3; ++c) {
            load(target, *(*whole)[c], precision_of(*(*whole)[c]), !rules.allowance.instead_of_compression, first,
                 count);
            if (!clamped.empty()) mark_open(target, *(*whole)[c], count);
            const Values& found = arithmetic.evaluate(c, first, count);
            for (std::size_t i = 0; i < count; ++i)
                errors[i][c] = error_of(found, target, i, rules, negative[i], !clamped.empty());
        }
        for (std::size_t i = 0; i < count; ++i) tally.add(first + i, errors[i], !clamped.empty() && clamped[first + i]);
        rebuild.add(first, std::span(errors).first(count));
    }
    SplitResult result = tally.finish();
    result.of = name_of(of);
    for (const ImageLayer* layer : sum.layers) result.layers.push_back(name_of(*layer));
    result.negative = std::move(signs);
    result.rebuild = rebuild.finish();
    result.rebuild.negative = std::move(signs_of_layers);
    result.bound_reason = bound_reason(planes, sum, rules);
    note_allowances(result, planes, rules.allowance);
    if (result.non_finite > 0) result.non_finite_layer = culprit(result, image, planes, names);
    return result;
}

}  // namespace raylex::display
