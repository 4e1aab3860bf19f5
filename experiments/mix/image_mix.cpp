#include "experiments/mix/image_mix.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "display/output/atlas/atlas_file.h"
#include "display/output/reader/exr_layers.h"
#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/stored_precision.h"
#include "display/output/writer/exr_edit.h"
#include "experiments/program/console.h"
#include "experiments/verify/presets.h"

namespace raylex::experiments {
namespace {

using display::ExrImage;
using display::ImageLayer;
using display::ImagePlane;
using Rgb = std::array<double, 3>;
using Layers = std::vector<const ImageLayer*>;

/// A sum of layers that the header declares, or that another renderer's names imply.
struct LightSplit {
    std::string name;
    const ImageLayer* of = nullptr;
    Layers layers;
    bool declared = false;
    bool plain = true;  ///< no layer is multiplied or subtracted
    display::Allowance allowance{};

    [[nodiscard]] bool has(const ImageLayer* layer) const {
        return std::find(layers.begin(), layers.end(), layer) != layers.end();
    }
};

std::string names_of(const Layers& layers) {
    std::vector<std::string> names;
    for (const ImageLayer* layer : layers) names.push_back(layer->name);
    return display::list_names(names);
}

/// Returns the declared partitions; if there are none, the splits of other renderers.
std::vector<LightSplit> splits_of(const ExrImage& image) {
    std::vector<LightSplit> splits;
    for (const display::PartitionDeclaration& partition : image.partitions) {
        LightSplit split{partition.name, image.layer(partition.of), {}, true, true, {}};
        for (const std::string& name : partition.layers) split.layers.push_back(image.layer(name));
        if (split.of != nullptr && !split.layers.empty() && !split.has(nullptr)) splits.push_back(std::move(split));
    }
    if (!splits.empty()) return splits;
    for (const Preset& preset : presets()) {
        const auto found = find_splits(preset, image, "");
        if (!found) continue;
        for (const FoundSplit& each : *found) {
            const ImageLayer* of = image.layer(each.of);
            const auto sum = display::parse_sum(image, *of, {each.sum});
            if (!sum) continue;
            const bool plain = std::none_of(sum->steps.begin(), sum->steps.end(), [](const display::SumStep& step) {
                using enum display::SumStep::Kind;
                return step.kind == multiply || step.kind == subtract || step.kind == negate;
            });
            splits.push_back({each.title, of, sum->layers, false, plain, each.allowance});
        }
    }
    return splits;
}

/// Finds a layer by its name, or by the name of a light group.
Result<const ImageLayer*> layer_of(const ExrImage& image, const ColorFactor& factor) {
    for (const ImageLayer& layer : image.layers)
        if (layer.name == factor.name) return &layer;
    // Different groups can have names that are equal as names of layers, so the expression decides.
    const std::string events = "<L.'" + (factor.name == "default" ? "" : factor.name) + "'>";
    for (const ImageLayer& layer : image.layers)
        if (const auto lpe = image.attributes.find("lpe/" + layer.name);
            layer.name.starts_with("light_") && lpe != image.attributes.end() && lpe->second.ends_with(events))
            return &layer;
    std::string group = factor.name;
    for (char& c : group)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') c = '_';
    for (const std::string& name : {"light_" + group, "Combined_" + factor.name, "RGBA_" + factor.name})
        if (const auto found = image.require_layer(name)) return *found;
    auto found = image.require_layer(factor.name);
    if (found) return found;
    Error error = found.error();
    error.file = factor.where.file;
    error.line = factor.where.line;
    error.column = factor.where.column;
    return error;
}

class ImageMixPlan {
  public:
    explicit ImageMixPlan(const ExrImage& image) : image_(image), splits_(splits_of(image)) {}

    Status run(const std::vector<ColorFactor>& lights) {
        Layers named;
        for (const ColorFactor& light : lights) {
            const auto layer = layer_of(image_, light);
            if (!layer) return layer.error();
            if (std::find(named.begin(), named.end(), *layer) != named.end())
                return error_at(light.where, "layer '" + (*layer)->name + "' has two factors; expected one");
            named.push_back(*layer);
        }
        if (Status chosen = choose_split(named, lights); !chosen) return chosen;
        for (const ImageLayer* layer : family_) factors_[layer] = {1, 1, 1};
        for (std::size_t i = 0; i < named.size(); ++i) {
            factors_[named[i]] = lights[i].rgb;
            changes_ = changes_ || !lights[i].is_one();
            result.scaled.push_back(named[i]->name);
        }
        for (const ImageLayer* layer : family_)
            if (std::find(named.begin(), named.end(), layer) == named.end()) result.kept.push_back(layer->name);
        if (!changes_) return success();
        follow_splits();
        follow_statistics();
        return check_planes();
    }

    [[nodiscard]] display::ExrEdit edit() {
        display::ExrEdit edit;
        if (changes_) {
            add_planes(*whole_, true, edit);
            for (const auto& [layer, factor] : factors_) add_planes(*layer, factor != Rgb{1, 1, 1}, edit);
        }
        for (const ImageLayer* layer : left_out_)
            for (const ImagePlane& plane : layer->planes) edit.removed.insert({plane.part, plane.channel});
        edit.change = [this](const display::PixelRegion&, std::span<std::vector<float>> planes) { change(planes); };
        edit.drops_attribute = [this](const std::string& name) { return drops(name); };
        const double magnitude = display::light_magnitude_of(image_.attributes);
        double largest = 1;
        for (const auto& [layer, factor] : factors_)
            for (const double each : factor) largest = std::max(largest, each);
        if (magnitude > 0) edit.attributes[display::light_magnitude] = number_text(magnitude * largest, 9);
        return edit;
    }

    /// Completes the result after the file was written.
    void conclude() {
        result.unassigned = light_ != 0 ? unassigned_ / light_ : 0;
        for (const ImageLayer* layer : left_out_) result.left_out.push_back("layer '" + layer->name + "'");
        for (const std::string& name : dropped_splits_) result.left_out.push_back("partition '" + name + "'");
    }

    MixedImage result;

  private:
    Status choose_split(const Layers& named, const std::vector<ColorFactor>& lights) {
        const auto whole = image_.require_layer("");
        if (!whole) return whole.error();
        whole_ = *whole;
        std::string choices;
        bool some_split = false;
        for (const LightSplit& split : splits_) {
            const bool nested = std::any_of(splits_.begin(), splits_.end(),
                                            [&](const LightSplit& other) { return other.has(split.of); });
            std::size_t inside = 0;
            for (const ImageLayer* layer : named) inside += split.has(layer) ? 1 : 0;
            some_split = some_split || inside > 0;
            if (nested || !split.plain || split.of != whole_) continue;
            choices += (choices.empty() ? "" : "; ") + split.name + " (" + names_of(split.layers) + ")";
            if (inside != named.size()) continue;
            chosen_ = &split;
            family_ = split.layers;
            result.is_proved = split.declared;
            result.is_whole = true;
            return success();
        }
        const bool is_whole = std::find(named.begin(), named.end(), whole_) != named.end();
        if (!some_split && !is_whole && image_.partitions.empty()) {
            family_ = named;
            return success();
        }
        return error_at(lights.front().where,
                        "the layers " + names_of(named) + " are no terms of one sum of " +
                            display::list_names({whole_->name}) + ", so their light could count twice; expected " +
                            (choices.empty() ? "layers of light groups" : "layers of one of: " + choices));
    }

    [[nodiscard]] bool follows(const ImageLayer* layer) const { return factors_.count(layer) > 0; }

    void leave_out(const ImageLayer* layer) {
        if (layer == whole_ || follows(layer)) return;
        if (std::find(left_out_.begin(), left_out_.end(), layer) == left_out_.end()) left_out_.push_back(layer);
    }

    /// Partitions of a layer with a factor follow it; all other light is left out.
    void follow_splits() {
        for (std::size_t before = 0; before != factors_.size();) {
            before = factors_.size();
            for (const LightSplit& split : splits_)
                if (split.plain && split.of != whole_ && follows(split.of))
                    for (const ImageLayer* layer : split.layers) factors_.try_emplace(layer, factors_[split.of]);
        }
        for (bool again = true; again;) {
            again = false;
            for (const LightSplit& split : splits_) {
                const bool gone = std::find(left_out_.begin(), left_out_.end(), split.of) != left_out_.end();
                const bool stale = std::any_of(split.layers.begin(), split.layers.end(),
                                               [&](const ImageLayer* layer) { return !follows(layer); });
                if (&split == chosen_ || !(gone || (split.of == whole_ && stale))) continue;
                again = dropped_splits_.insert(split.name).second || again;
                for (const ImageLayer* layer : split.layers)
                    if (split.plain || !layer->name.ends_with("Col")) leave_out(layer);  // a colour is no light
            }
        }
        for (const ImageLayer& layer : image_.layers)
            if (image_.attributes.count("lpe/" + layer.name) > 0 && statistic_of(layer).second == nullptr)
                leave_out(&layer);
    }

    /// Returns the statistic of a layer and the layer that it describes: "mse", "even", "error"; null without one.
    [[nodiscard]] std::pair<std::string, const ImageLayer*> statistic_of(const ImageLayer& layer) const {
        const auto found = image_.attributes.find("statistics/" + layer.name);
        if (found != image_.attributes.end())
            if (const std::size_t of = found->second.find(" of "); of != std::string::npos)
                return {found->second.substr(0, of), image_.layer(found->second.substr(of + 4))};
        for (const std::string kind : {"error", "noisy"})
            if (layer.name.ends_with("_" + kind))
                return {kind, image_.layer(layer.name.substr(0, layer.name.size() - kind.size() - 1))};
        return {};
    }

    void follow_statistics() {
        for (const ImageLayer& layer : image_.layers) {
            const auto [kind, of] = statistic_of(layer);
            if (of == nullptr) continue;
            if (of == whole_ || std::find(left_out_.begin(), left_out_.end(), of) != left_out_.end()) {
                leave_out(&layer);
            } else if (follows(of)) {
                Rgb factor = factors_[of];
                const bool single = layer.triple()[0] == layer.triple()[1],
                           grey = factor[0] == factor[1] && factor[1] == factor[2];
                if (kind == "mse" || kind == "variance")
                    for (double& each : factor) each *= each;
                if (single && !grey) leave_out(&layer);
                else factors_.try_emplace(&layer, factor);
            }
        }
    }

    Status check_planes() const {
        for (const auto& [layer, factor] : factors_)
            if (layer->triple()[0] == nullptr)
                return error_at({image_.path, 0, 0},
                                "layer '" + layer->name + "' has no red, green and blue; expected layers of light");
        for (const ImageLayer* layer : family_) {
            const Rgb& factor = factors_.at(layer);
            if (!layer->is_color() && (factor[0] != factor[1] || factor[1] != factor[2] || chosen_ == nullptr))
                return error_at({image_.path, 0, 0}, "layer '" + layer->name +
                                                         "' has no red, green and blue; expected a layer of light, or "
                                                         "one number for a layer of a partition");
        }
        if (whole_->is_color()) return success();
        return error_at({image_.path, 0, 0}, "the beauty has no red, green and blue; expected an image in colour");
    }

    void add_planes(const ImageLayer& layer, bool changed, display::ExrEdit& edit) {
        for (const ImagePlane* plane : layer.triple()) {
            if (index_.try_emplace(plane, edit.planes.size()).second)
                edit.planes.push_back({plane->part, plane->channel});
            if (changed) edit.changed.insert({plane->part, plane->channel});
        }
    }

    [[nodiscard]] bool drops(const std::string& name) const {
        if (!changes_) return false;
        const std::size_t slash = name.find('/');
        if (slash == std::string::npos) return false;
        const std::string kind = name.substr(0, slash), of = name.substr(slash + 1);
        if (kind == "verdict" || name == "raylex/is_beauty") return true;
        if (kind == "partition") return dropped_splits_.count(of) > 0;
        return std::any_of(left_out_.begin(), left_out_.end(),
                           [&](const ImageLayer* layer) { return layer->name == of; });
    }

    /// Rounds to the type of the plane; numbers beyond its range become its largest.
    static float stored(double value, const ImagePlane& plane) {
        const auto largest = static_cast<double>(display::largest_of(plane.stored));
        return std::isfinite(value) ? static_cast<float>(std::clamp(value, -largest, largest))
                                    : static_cast<float>(value);
    }

    void change(std::span<std::vector<float>> planes) {
        for (std::size_t c = 0; c < 3; ++c) change_beauty(c, planes);
        for (const auto& [layer, factor] : factors_) {
            const auto triple = layer->triple();
            for (std::size_t c = 0; c < (triple[0] == triple[1] ? 1 : 3); ++c) {
                if (factor[c] == 1) continue;
                for (float& value : planes[index_.at(triple[c])])
                    value = factor[c] == 0 ? 0.0f : stored(factor[c] * static_cast<double>(value), *triple[c]);
            }
        }
    }

    /// Computes one component of the beauty from the layers, which are not scaled yet.
    void change_beauty(std::size_t c, std::span<std::vector<float>> planes) {
        struct Term {
            const float* values;
            double factor;
            display::StoredPrecision precision;
            display::StoredType stored;
        };
        std::vector<Term> terms;
        for (const ImageLayer* layer : family_) {
            const ImagePlane* plane = layer->triple()[c];
            terms.push_back(
                {planes[index_.at(plane)].data(), factors_.at(layer)[c], display::precision_of(*plane), plane->stored});
        }
        const ImagePlane& target = *whole_->triple()[c];
        const display::StoredPrecision precision = display::precision_of(target);
        const double cancelled = display::cancelled_unit * display::light_magnitude_of(image_.attributes);
        const display::Allowance allowance = chosen_ != nullptr ? chosen_->allowance : display::Allowance{};
        const auto rounding_of = [](double value, const display::StoredPrecision& of) {
            return of.unit * std::abs(value) + of.spacing + (of.dwa > 0 ? display::dwa_change(value, of.dwa) : 0);
        };
        std::vector<float>& whole = planes[index_.at(&target)];
        for (std::size_t i = 0; i < whole.size(); ++i) {
            const auto before = static_cast<double>(whole[i]);
            double total = 0, scaled = 0, rounding = rounding_of(before, precision) + cancelled + allowance.absolute;
            bool changes = false, clamped = display::is_clamped(whole[i], target.stored);
            for (const Term& term : terms) {
                const auto value = static_cast<double>(term.values[i]);
                total += value;
                scaled += term.factor == 0 ? 0 : term.factor * value;
                rounding += rounding_of(value, term.precision) + allowance.relative * std::abs(value);
                clamped = clamped || display::is_clamped(term.values[i], term.stored);
                changes = changes || (term.factor != 1 && value != 0);
            }
            // What a clamp took is no light of its own, and infinite light has no rest.
            const bool is_known = std::isfinite(before) && std::isfinite(total) && !clamped;
            const double rest = !is_known || std::abs(before - total) <= rounding ? 0 : before - total;
            if (is_known) {
                unassigned_ += rest;
                light_ += before;
            }
            if (const double after = scaled + rest; changes && std::isfinite(after)) whole[i] = stored(after, target);
        }
    }

    const ExrImage& image_;
    std::vector<LightSplit> splits_;
    const LightSplit* chosen_ = nullptr;
    const ImageLayer* whole_ = nullptr;
    Layers family_;                             // the terms of the chosen split
    std::map<const ImageLayer*, Rgb> factors_;  // of every layer of light that follows
    Layers left_out_;
    std::set<std::string> dropped_splits_;
    std::map<const ImagePlane*, std::size_t> index_;  // in ExrEdit::planes
    bool changes_ = false;
    double unassigned_ = 0, light_ = 0;
};

}  // namespace

Result<MixedImage> mix_image(const std::string& from, const std::string& to, const Mix& mix,
                             const std::string& command) {
    if (!to.ends_with(".exr")) return error_at({to, 0, 0}, "is no OpenEXR file; expected a name that ends in .exr");
    if (std::error_code failed; from == to || std::filesystem::equivalent(from, to, failed))
        return error_at({to, 0, 0}, "the output is the input and would be overwritten; expected another file");
    if (display::is_atlas(from))
        return error_at({from, 0, 0}, "this is a path atlas; expected an image with layers of light groups",
                        "raylex ask --light mixes an atlas");
    if (!mix.colors.empty())
        return error_at(mix.colors.front().where,
                        "'" + mix.colors.front().name +
                            "' is a colour of an object, and an image has no light by objects; expected only [light]",
                        "an atlas has it: raylex ask FILE.atlas.exr --mix");
    const std::vector<ColorFactor>& lights = mix.lights;
    if (lights.empty())
        return error_at({"mix", 0, 0}, "no factors; expected LAYER=FACTOR, such as light_key=1.5, or --mix FILE.toml");
    if (Status once = check_once(lights); !once) return once.error();
    const auto file = display::ExrBands::open(from);
    if (!file) return file.error();
    // Names of other renderers imply a split only together with pixels: a transparent film subtracts the environment.
    std::optional<ExrImage> pixels;
    if (file->image().partitions.empty()) {
        auto read = display::read_exr(from);
        if (!read) return read.error();
        pixels = *std::move(read);
    }
    ImageMixPlan plan(pixels ? *pixels : file->image());
    if (Status planned = plan.run(lights); !planned) return planned.error();
    display::ExrEdit edit = plan.edit();
    const auto earlier = file->image().attributes.find("raylex/mix");
    edit.attributes["raylex/mix"] =
        (earlier == file->image().attributes.end() ? "" : earlier->second + "; ") + factors_text(lights);
    edit.attributes["raylex/mix_command"] = command;
    if (Status written = display::edit_exr(from, to, edit); !written) return written.error();
    plan.conclude();
    return std::move(plan.result);
}

}  // namespace raylex::experiments
