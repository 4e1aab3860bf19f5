#include "display/output/denoise/denoised_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include "display/output/reader/exr_layers.h"
#include "display/output/splits/split_check.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

constexpr const char* denoised_attribute = "raylex/denoised";
constexpr std::array statistic_suffixes{"_mse", "_even", "_odd", "_variance"};
constexpr float largest_denoised = 1e15f;  ///< squares of larger values are no floats

std::string name_in_text(const std::string& name) {
    return name.empty() ? "beauty" : name;
}

/// One channel of the filter: its planes and where the variance comes from.
class Statistics {
  public:
    Statistics(const ExrImage& image, const ExrImage* second) : image_(image), second_(second) {}

    /// Returns whether the variance of the layer is known.
    [[nodiscard]] bool has(const ImageLayer& layer) const {
        if (second_ != nullptr) {
            const ImageLayer* other = second_->layer(layer.name);
            return other != nullptr &&
                   std::all_of(layer.planes.begin(), layer.planes.begin() + 3,
                               [&](const ImagePlane& p) { return other->plane(p.name) != nullptr; });
        }
        return statistic(layer, "_mse") != nullptr ||
               (statistic(layer, "_even") != nullptr && statistic(layer, "_odd") != nullptr);
    }
    /// The variance of plane `p` of the layer, which becomes the mean of two renders if there is a second.
    [[nodiscard]] std::vector<float> variance(const ImageLayer& layer, std::size_t p,
                                              std::vector<float>& values) const {
        if (second_ != nullptr) {
            const ImagePlane* other = second_->layer(layer.name)->plane(layer.planes[p].name);
            std::vector<float> squares = half_difference(values, other->values);
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.5f * (values[i] + other->values[i]);
            return squares;
        }
        if (const ImageLayer* mse = statistic(layer, "_mse"); mse != nullptr) return plane_of(*mse, layer, p).values;
        return half_difference(plane_of(*statistic(layer, "_even"), layer, p).values,
                               plane_of(*statistic(layer, "_odd"), layer, p).values);
    }
    [[nodiscard]] const ImageLayer* statistic(const ImageLayer& layer, const char* suffix) const {
        const ImageLayer* found = image_.layer(name_in_text(layer.name) + suffix);
        return found != nullptr && found->planes.size() >= std::min<std::size_t>(3, layer.planes.size()) ? found
                                                                                                         : nullptr;
    }

  private:
    static const ImagePlane& plane_of(const ImageLayer& statistic, const ImageLayer& layer, std::size_t p) {
        const ImagePlane* found = statistic.plane(layer.planes[p].name);
        return found != nullptr ? *found : statistic.planes[p];
    }
    static std::vector<float> half_difference(const std::vector<float>& a, const std::vector<float>& b) {
        std::vector<float> squares(a.size());
        for (std::size_t i = 0; i < a.size(); ++i) squares[i] = 0.25f * (a[i] - b[i]) * (a[i] - b[i]);
        return squares;
    }
    const ExrImage& image_;
    const ExrImage* second_;
};

const ImageLayer* feature_named(const ExrImage& image, std::initializer_list<const char*> names) {
    for (const char* name : names)
        if (auto found = resolve_layer(image, name); found && (*found)->planes.size() >= 3) return *found;
    return nullptr;
}

bool is_statistic(const ExrImage& image, const std::string& name) {
    return std::any_of(statistic_suffixes.begin(), statistic_suffixes.end(), [&](const char* suffix) {
        const std::string end = suffix;
        if (!name.ends_with(end)) return false;
        return resolve_layer(image, name.substr(0, name.size() - end.size())).ok();
    });
}

class ImageDenoiser {
  public:
    ImageDenoiser(ExrImage& image, const ExrImage* second, const DenoiseOptions& options)
        : image_(image), second_(second), statistics_(image, second), options_(options) {}

    Result<DenoisedImage> run() {
        if (image_.attributes.contains(denoised_attribute))
            return error_at({image_.path, 0, 0}, "the image is denoised already; expected the noisy one");
        choose_features();
        choose_layers();
        for (Status (ImageDenoiser::*step)() : {&ImageDenoiser::check_layers, &ImageDenoiser::read_sums,
                                                &ImageDenoiser::check_sums, &ImageDenoiser::take_planes})
            if (Status done = (this->*step)(); !done) return std::move(done).error();
        const std::vector<LayerError> errors = denoise(noisy_, options_.threads);
        for (std::size_t i = 0; i < chosen_.size(); ++i) result_.layers.push_back({names_[i], errors[i]});
        give_planes();
        describe();
        return std::move(result_);
    }

  private:
    void choose_features() {
        for (const ImageLayer* found :
             {feature_named(image_, {"albedo", "Denoising Albedo", "DiffCol"}),
              feature_named(image_, {"Nn", "__Nworld", "Denoising Normal", "normal", "Normal", "N"})}) {
            if (found == nullptr) continue;
            features_.insert(found);
            result_.features.push_back(found->name);
        }
    }

    /// The beauty comes first, because it guides the filter of all.
    void choose_layers() {
        for (std::size_t i = 0; i < image_.layers.size(); ++i) {
            const ImageLayer& layer = image_.layers[i];
            const bool is_light = layer.is_color() && !features_.contains(&layer) &&
                                  !lower_case(layer.name).starts_with("crypto") && !is_statistic(image_, layer.name);
            if (!is_light || !statistics_.has(layer)) continue;
            chosen_.push_back(i);
            names_.push_back(name_in_text(layer.name));
        }
        if (auto beauty = image_.require_layer(""); beauty) {
            const auto index = static_cast<std::size_t>(*beauty - image_.layers.data());
            const auto at = std::find(chosen_.begin(), chosen_.end(), index);
            if (at == chosen_.end()) return;
            std::rotate(names_.begin(), names_.begin() + (at - chosen_.begin()),
                        names_.begin() + (at - chosen_.begin()) + 1);
            std::rotate(chosen_.begin(), at, at + 1);
        }
    }

    Status check_layers() {
        const auto window = [](const ExrImage& image) {
            const PixelRegion region = image.data_window.value_or(PixelRegion{0, 0, image.width, image.height});
            return std::array{image.width, image.height, region.x0, region.y0, region.x1, region.y1};
        };
        if (second_ != nullptr && window(*second_) != window(image_))
            return error_at({second_->path, 0, 0},
                            "the second image has another size or data window; expected those of " + image_.path);
        if (!chosen_.empty()) return check_values();
        return error_at({image_.path, 0, 0},
                        "no layer of light has statistics, so its noise is unknown; expected NAME_mse (the variance "
                        "of a pixel), or NAME_even and NAME_odd (two halves of the samples), or a second image of "
                        "other random numbers by --second",
                        "raylex render --denoise keeps them");
    }

    /// Refuses images that the filter would change for the worse, or whose layers would no longer sum.
    Status check_values() {
        if (const auto beauty = image_.require_layer(""); beauty && *beauty != &image_.layers[chosen_.front()])
            return error_at({image_.path, 0, 0},
                            "the beauty has no statistics, and guides the filter of all layers; expected "
                            "'beauty_mse', or 'beauty_even' and 'beauty_odd'");
        std::set<std::string> names;
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            const ImageLayer& layer = image_.layers[chosen_[i]];
            if (!names.insert(names_[i]).second)
                return error_at({image_.path, 0, 0},
                                "two layers are called '" + names_[i] + "'; expected one of each name");
            for (const std::string& added : {names_[i] + "_error", names_[i] + "_noisy"})
                if (image_.layer(added) != nullptr && (options_.keep_noisy || added.ends_with("_error")))
                    return error_at(
                        {image_.path, 0, 0},
                        "the layer '" + added + "' exists; expected no layer of the name that a new layer gets");
            for (const ImagePlane& plane : std::span(layer.planes).first(3))
                if (!image_.partitions.empty() &&
                    (plane.stored != StoredType::single_float || plane.loss != PlaneLoss::none))
                    return error_at({image_.path, 0, 0},
                                    "the layer '" + names_[i] +
                                        "' is stored as half or with loss, so the layers of its partitions sum only "
                                        "roughly; expected float with a lossless compression",
                                    "render without --exr light=half");
        }
        return success();
    }

    Status read_sums() {
        for (const PartitionDeclaration& partition : image_.partitions) {
            LayerIdentity identity;
            std::vector<std::string> needed = partition.layers;
            needed.push_back(name_in_text(partition.of));
            for (const std::string& name : needed) {
                const auto found = std::find(names_.begin(), names_.end(), name);
                if (found == names_.end())
                    return error_at({image_.path, 0, 0},
                                    "the layer '" + name + "' of partition '" + partition.name +
                                        "' has no statistics, and a partition is denoised as a whole; expected '" +
                                        name + "_mse'",
                                    "raylex render --denoise, or --statistics " + name + "=mse, keeps it");
                identity.layers.push_back(static_cast<std::size_t>(found - names_.begin()));
            }
            identity.of = identity.layers.back();
            identity.layers.pop_back();
            noisy_.sums.push_back(std::move(identity));
        }
        return success();
    }

    /// Refuses layers that do not sum. After denoising they would, and hide the missing light.
    Status check_sums() {
        for (const ExrImage* image : {static_cast<const ExrImage*>(&image_), second_}) {
            if (image == nullptr) continue;
            const auto results = check_declared_splits(*image);
            if (!results) return results.error();
            for (const SplitResult& result : *results)
                if (result.exceeding > 0)
                    return error_at({image->path, 0, 0},
                                    "the layers of partition '" + result.partition + "' do not sum to '" +
                                        name_in_text(result.of) + "'; expected layers that sum",
                                    "raylex verify shows where");
        }
        return success();
    }

    /// The pixels inside the data window.
    [[nodiscard]] std::vector<float> inside(std::vector<float> plane) const {
        if (!image_.data_window) return plane;
        std::vector<float> values;
        for (int y = region_.y0; y < region_.y1; ++y) {
            const auto row = plane.begin() + std::ptrdiff_t{image_.width} * y;
            values.insert(values.end(), row + region_.x0, row + region_.x1);
        }
        return values;
    }
    /// The plane with these pixels inside the data window, and 0 outside.
    [[nodiscard]] std::vector<float> placed(std::vector<float> values) const {
        if (!image_.data_window) return values;
        std::vector<float> plane(static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height));
        for (int y = region_.y0; y < region_.y1; ++y)
            std::copy_n(values.begin() + std::ptrdiff_t{region_.width()} * (y - region_.y0), region_.width(),
                        plane.begin() + std::ptrdiff_t{image_.width} * y + region_.x0);
        return plane;
    }

    /// Statistics take half of the memory, and are left out of the result.
    void free_statistics(const ImageLayer& of) {
        for (ImageLayer& layer : image_.layers)
            for (const char* suffix : {"_mse", "_even", "_odd"})
                if (statistics_.statistic(of, suffix) == &layer)
                    for (ImagePlane& plane : layer.planes) plane.values = std::vector<float>();
    }

    /// Moves the planes of the chosen layers, and copies those of features.
    Status take_planes() {
        region_ = image_.data_window.value_or(PixelRegion{0, 0, image_.width, image_.height});
        noisy_.width = region_.width();
        noisy_.height = region_.height();
        for (const ImageLayer* layer : features_)
            for (std::size_t p = 0; p < 3; ++p) {
                FilterFeature feature{layer->planes[p].values, {}};
                if (statistics_.has(*layer)) feature.variance = statistics_.variance(*layer, p, feature.values);
                for (float& value : feature.values) value = std::abs(value) <= largest_denoised ? value : 0.0f;
                for (float& value : feature.variance) value = value >= 0 && value <= largest_denoised ? value : 0.0f;
                feature.values = inside(std::move(feature.values));
                if (!feature.variance.empty()) feature.variance = inside(std::move(feature.variance));
                noisy_.features.push_back(std::move(feature));
            }
        for (const std::size_t i : chosen_) {
            ImageLayer& layer = image_.layers[i];
            NoisyLayer& noisy = noisy_.layers.emplace_back();
            for (std::size_t p = 0; p < 3; ++p) {
                std::vector<float>& values = layer.planes[p].values;
                noisy.variance[p] = inside(statistics_.variance(layer, p, values));
                constexpr float most = largest_denoised * largest_denoised;
                if (!std::ranges::all_of(values, [](float value) { return std::abs(value) <= largest_denoised; }) ||
                    !std::ranges::all_of(noisy.variance[p], [](float v) { return v >= 0 && v <= most; }))
                    return error_at({image_.path, 0, 0},
                                    "the layer '" + names_[noisy_.layers.size() - 1] + "' has values" +
                                        (second_ == nullptr ? "" : ", here or in " + second_->path + ",") +
                                        " that are not finite or above 1e15, or a negative variance; "
                                        "expected none");
                noisy.values[p] = options_.keep_noisy ? inside(values) : inside(std::move(values));
            }
            if (!options_.keep_noisy) free_statistics(layer);
        }
        const auto is_zero = [](const std::vector<float>& plane) {
            return std::ranges::all_of(plane, [](float value) { return value == 0; });
        };
        const NoisyLayer& beauty = noisy_.layers.front();
        // A black image has no noise.
        if (std::ranges::all_of(beauty.variance, is_zero) && !std::ranges::all_of(beauty.values, is_zero))
            return error_at({image_.path, 0, 0}, "the variance of '" + names_.front() +
                                                     "' is 0 everywhere; expected at least two "
                                                     "samples a pixel, or a second image of other random numbers");
        return success();
    }

    void give_planes() {
        std::vector<ImageLayer> added;
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            ImageLayer& layer = image_.layers[chosen_[i]];
            if (options_.keep_noisy) {
                ImageLayer& noisy = added.emplace_back();
                noisy.name = noisy.part = names_[i] + "_noisy";
                noisy.planes.assign(layer.planes.begin(), layer.planes.begin() + 3);
            }
            NoisyLayer& denoised = noisy_.layers[i];
            for (std::size_t p = 0; p < 3; ++p) {
                layer.planes[p].values = placed(std::move(denoised.values[p]));
                layer.planes[p].stored = StoredType::single_float;
                layer.planes[p].loss = PlaneLoss::none;
            }
            for (float& value : denoised.variance[0]) value = std::sqrt(value);
            ImageLayer& error = added.emplace_back();
            error.name = error.part = names_[i] + "_error";
            // A dot separates the name of a layer from that of its plane.
            const bool has_dot = error.name.find('.') != std::string::npos;
            error.planes.push_back(
                {has_dot ? "Y" : error.name, StoredType::single_float, placed(std::move(denoised.variance[0]))});
        }
        std::set<std::string> obsolete;
        for (const std::vector<std::string>* names : {&names_, &result_.features})
            for (const std::string& name : *names)
                for (const char* suffix : statistic_suffixes) obsolete.insert(name + suffix);
        if (!options_.keep_noisy)
            std::erase_if(image_.layers, [&](ImageLayer& layer) {
                if (!obsolete.contains(layer.name)) return false;
                for (ImagePlane& plane : layer.planes) plane.values = std::vector<float>();
                result_.removed.push_back(layer);
                return true;
            });
        for (ImageLayer& layer : added) {
            result_.added.push_back(layer.name);
            image_.layers.push_back(std::move(layer));
        }
    }

    void describe() {
        std::string text = "raylex denoise: non-local means and first-order regression, radius 7; layers";
        for (const std::string& name : names_) text += " " + name;
        text += "; features";
        for (const std::string& name : result_.features) text += " " + name;
        if (result_.features.empty()) text += " none";
        result_.attributes[denoised_attribute] = text;
        for (const DenoisedLayer& layer : result_.layers) {
            std::array<char, 200> line{};
            std::snprintf(
                line.data(), line.size(),
                "mean squared error %.6g, before %.6g, estimated; 95 %% from %.3g to %.3g; light after / before %.6g",
                layer.error.after, layer.error.before, layer.error.least, layer.error.most,
                layer.error.light != 0 ? layer.error.light_after / layer.error.light : 1.0);
            result_.attributes["error/" + layer.name] = line.data();
        }
        for (const auto& [name, text_of_layer] : result_.attributes) image_.attributes[name] = text_of_layer;
    }

    ExrImage& image_;
    const ExrImage* second_;
    Statistics statistics_;
    const DenoiseOptions& options_;
    PixelRegion region_{};  // with pixels
    std::set<const ImageLayer*> features_;
    std::vector<std::size_t> chosen_;  // layers of the image
    std::vector<std::string> names_;
    NoisyImage noisy_;
    DenoisedImage result_;
};

}  // namespace

Result<DenoisedImage> denoise_image(ExrImage& image, const DenoiseOptions& options) {
    if (options.second.empty()) return ImageDenoiser(image, nullptr, options).run();
    auto second = read_exr(options.second);
    if (!second) return second.error();
    second->partitions = image.partitions;  // the mean of two images sums if both do
    return ImageDenoiser(image, &*second, options).run();
}

}  // namespace raylex::display
