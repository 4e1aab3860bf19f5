#include "display/output/color/color_manager.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>

#include <OpenColorIO/OpenColorIO.h>

#include "display/output/color/color_names.h"
#include "display/output/color/primaries.h"
#include "display/output/color/shipped_config.h"
#include "display/services/parameters.h"
#include "display/services/thread_or_none.h"
#include "lpe/input/read_input.h"

namespace ocio = OCIO_NAMESPACE;

namespace raylex::display {

namespace {

// Brighter than any view can show; the ACES views turn values near the end of the float range into black.
constexpr float largest_value = 1e6f;

std::string list(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? "(none)" : text;
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

// OpenColorIO provides its own text; this function adds the file and what was expected.
Error config_error(const std::string& file, const std::string& what, const std::string& why) {
    Error error;
    error.file = file;
    error.message = what + ": " + why;
    while (!error.message.empty() && error.message.back() == '\n') error.message.pop_back();
    return error;
}

Error unknown_name(const std::string& file, const std::string& kind, const std::string& name,
                   const std::vector<std::string>& known, const std::string& where = {}) {
    Error error;
    error.file = file;
    error.message =
        "the OpenColorIO config has no " + kind + " '" + name + "'" + where + "; expected one of: " + list(known);
    std::string near = nearest_name(name, known);
    // Names in configs are long ("sRGB - Display"), so a part of a name counts as a near miss, too.
    for (const std::string& each : known)
        if (near.empty() && !name.empty() && lower_case(each).find(lower_case(name)) != std::string::npos) near = each;
    if (!near.empty()) error.hint = "did you mean '" + near + "'?";
    return error;
}

std::array<double, 3> through(const ocio::ConstCPUProcessorRcPtr& processor, std::array<double, 3> colour) {
    float rgb[3] = {static_cast<float>(colour[0]), static_cast<float>(colour[1]), static_cast<float>(colour[2])};
    processor->applyRGB(rgb);
    return {rgb[0], rgb[1], rgb[2]};
}

// The processor as a matrix; nothing if it is not linear, which probes on and off the axes test.
std::optional<Matrix3> as_matrix(const ocio::ConstProcessorRcPtr& processor) {
    // Lossless, because the fast approximations would lose digits.
    const auto cpu = processor->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
    Matrix3 matrix{};
    for (std::size_t j = 0; j < 3; ++j) {
        std::array<double, 3> unit{};
        unit[j] = 1;
        const std::array<double, 3> column = through(cpu, unit);
        for (std::size_t i = 0; i < 3; ++i) matrix[i][j] = column[i];
    }
    for (const std::array<double, 3>& probe :
         {std::array{0.0, 0.0, 0.0}, std::array{0.18, 0.18, 0.18}, std::array{4.0, 0.5, 0.02}}) {
        const std::array<double, 3> direct = through(cpu, probe), linear = transform_colour(matrix, probe);
        for (std::size_t i = 0; i < 3; ++i)
            if (!(std::abs(direct[i] - linear[i]) <=
                  1e-4 * (1e-3 + std::abs(probe[0]) + std::abs(probe[1]) + std::abs(probe[2]))))
                return std::nullopt;
    }
    return matrix;
}

}  // namespace

struct ColorManager::Config {
    ocio::ConstConfigRcPtr config;
    std::string file;              // for messages: the path, or the name of the shipped config
    std::string interchange;       // a scene-linear (or XYZ) space of the config ...
    Matrix3 interchange_to_xyz{};  // ... and its matrix to XYZ D65
    bool assumed = false;          // the interchange is an assumption

    void find_interchange();
    [[nodiscard]] bool has_space(const std::string& name) const {
        return config->getColorSpace(name.c_str()) != nullptr;
    }
    [[nodiscard]] bool is_scene_linear(const ocio::ConstColorSpaceRcPtr& space) const;
    [[nodiscard]] std::vector<std::string> scene_linear_spaces() const;
    /// The matrix from XYZ D65 to a space.
    [[nodiscard]] Result<Matrix3> from_xyz(const std::string& space) const;
    /// Runs `action` and converts OpenColorIO's exceptions to an Error about `what`.
    template <class Action>
    auto guarded(const std::string& what, Action action) const -> decltype(action()) {
        try {
            return action();
        } catch (const std::exception& exception) { return config_error(file, what, exception.what()); }
    }
};

void ColorManager::Config::find_interchange() {
    for (const char* name : {"aces_interchange", "ACES2065-1", "ACES - ACES2065-1"})
        if (has_space(name)) {
            interchange = name;
            interchange_to_xyz = rgb_to_xyz_d65(aces_ap0_primaries());
            return;
        }
    if (has_space("cie_xyz_d65_interchange")) {
        interchange = "cie_xyz_d65_interchange";
        interchange_to_xyz = identity_matrix();
        return;
    }
    assumed = true;
    interchange_to_xyz = rgb_to_xyz_d65(rec709_primaries());
    for (const char* name : {"scene_linear", "rendering", "reference", "default"})
        if (has_space(name)) {
            interchange = name;
            return;
        }
    interchange = config->getColorSpaceNameByIndex(0);
}

bool ColorManager::Config::is_scene_linear(const ocio::ConstColorSpaceRcPtr& space) const {
    if (!space || space->isData() || space->getReferenceSpaceType() != ocio::REFERENCE_SPACE_SCENE) return false;
    const std::string encoding = space->getEncoding();
    if (!encoding.empty()) return encoding == "scene-linear";
    // Version 1 configs have no such field, so the numbers decide.
    try {
        return as_matrix(config->getProcessor(space->getName(), interchange.c_str())).has_value();
    } catch (const std::exception&) {
        return false;  // a missing look-up table makes only this space unusable
    }
}

std::vector<std::string> ColorManager::Config::scene_linear_spaces() const {
    std::vector<std::string> names;
    for (int i = 0; i < config->getNumColorSpaces(); ++i) {
        const char* name = config->getColorSpaceNameByIndex(i);
        if (is_scene_linear(config->getColorSpace(name))) names.emplace_back(name);
    }
    return names;
}

Result<Matrix3> ColorManager::Config::from_xyz(const std::string& space) const {
    return guarded("cannot convert to colour space '" + space + "'", [&]() -> Result<Matrix3> {
        const ocio::ConstColorSpaceRcPtr found = config->getColorSpace(space.c_str());
        if (!found) return unknown_name(file, "colour space", space, scene_linear_spaces());
        if (!is_scene_linear(found)) {
            Error error;
            error.file = file;
            error.message = "colour space '" + space + "' is " + (found->isData() ? "data" : "not scene-linear") +
                            "; expected one of: " + list(scene_linear_spaces());
            return error;
        }
        const std::optional<Matrix3> matrix = as_matrix(config->getProcessor(interchange.c_str(), space.c_str()));
        if (!matrix)
            return config_error(file, "cannot convert to colour space '" + space + "'", "the conversion is not linear");
        return multiply(*matrix, inverse(interchange_to_xyz));
    });
}

ColorManager::ColorManager(std::unique_ptr<Config> config) : config_(std::move(config)) {}
ColorManager::~ColorManager() = default;
ColorManager::ColorManager(ColorManager&&) noexcept = default;
ColorManager& ColorManager::operator=(ColorManager&&) noexcept = default;

namespace {

struct NamedConfig {
    ocio::ConstConfigRcPtr config;
    std::string file;  // for messages
};

// Reads `config_path`, or else $OCIO, or else the shipped config. A config without a colour space is an error.
Result<NamedConfig> read_config(const std::string& config_path) {
    const char* environment = std::getenv("OCIO");
    const std::string path = !config_path.empty() ? config_path : environment != nullptr ? environment : "";
    const bool from_environment = config_path.empty() && !path.empty();
    NamedConfig read{nullptr, path.empty() ? "the config shipped with raylex" : path};
    std::error_code ignored;
    if (!path.empty() && std::filesystem::exists(path, ignored))
        if (Status regular = check_regular_file(path, "a config file"); !regular)
            return config_error(path, "cannot read the OpenColorIO config", regular.error().message);
    const auto failed = [&](const std::exception& exception) {
        Error error = config_error(
            read.file,
            std::string("cannot read the OpenColorIO config") + (from_environment ? " that $OCIO names" : ""),
            exception.what());
        error.message += "; expected a config file of profile version 1, 2.0 or 2.1 (OpenColorIO " +
                         std::string(ocio::GetVersion()) + ")";
        error.hint = from_environment ? "unset OCIO or name a file with --ocio to override it"
                                      : "without --ocio and $OCIO the shipped config is used";
        return error;
    };
    try {
        if (path.empty()) {
            std::istringstream text{std::string(shipped_config_text())};
            read.config = ocio::Config::CreateFromStream(text);
        } else {
            read.config = ocio::Config::CreateFromFile(path.c_str());
        }
        if (read.config->getNumColorSpaces() > 0) return read;
        return config_error(read.file, "the OpenColorIO config cannot be used",
                            "it defines no colour space; expected at least one");
    } catch (const std::exception& exception) { return failed(exception); }
}

}  // namespace

Result<ColorManager> ColorManager::open(const std::string& config_path) {
    Result<NamedConfig> read = read_config(config_path);
    if (!read) return std::move(read).error();
    auto config = std::make_unique<Config>();
    config->config = read->config;
    config->file = read->file;
    try {
        config->find_interchange();
    } catch (const std::exception& exception) {
        return config_error(config->file, "the OpenColorIO config cannot be used", exception.what());
    }
    return ColorManager(std::move(config));
}

Result<ConfigNames> config_names(const std::string& config_path) {
    const Result<ColorManager> manager = ColorManager::open(config_path);
    if (!manager) return manager.error();
    const Result<NamedConfig> read = read_config(config_path);
    if (!read) return read.error();
    const std::vector<std::string> linear = manager->scene_linear_spaces();
    ConfigNames names;
    for (int i = 0; i < read->config->getNumColorSpaces(); ++i) {
        const char* name = read->config->getColorSpaceNameByIndex(i);
        names.spaces.push_back({name, holds(linear, name), read->config->getColorSpace(name)->isData()});
    }
    for (int i = 0; i < read->config->getNumLooks(); ++i) names.looks.emplace_back(read->config->getLookNameByIndex(i));
    return names;
}

Status check_view(const ColorManager& color, const std::string& display, const std::string& view) {
    const std::vector<std::string> displays = color.displays();
    if (!display.empty() && !holds(displays, display))
        return unknown_name(color.description(), "display", display, displays);
    const std::string chosen = display.empty() ? color.default_display() : display;
    const std::vector<std::string> views = color.views(chosen);
    if (view.empty() || holds(views, view)) return success();
    Error error = unknown_name(color.description(), "view", view, views, " of display '" + chosen + "'");
    for (const std::string& other : displays)
        if (error.hint.empty() && holds(color.views(other), view))
            error.hint = "display '" + other + "' has such a view";
    return error;
}

std::string ColorManager::description() const {
    const std::string name = config_->config->getName();
    std::string text = config_->file + (name.empty() ? "" : " (" + name + ")");
    if (config_->assumed)
        text += ", which has no interchange role: '" + config_->interchange + "' is assumed to have Rec. 709 primaries";
    return text;
}

std::vector<std::string> ColorManager::scene_linear_spaces() const {
    return config_->scene_linear_spaces();
}

std::vector<std::string> ColorManager::displays() const {
    std::vector<std::string> names;
    for (int i = 0; i < config_->config->getNumDisplays(); ++i) names.emplace_back(config_->config->getDisplay(i));
    return names;
}

std::vector<std::string> ColorManager::views(const std::string& display) const {
    std::vector<std::string> names;
    for (int i = 0; i < config_->config->getNumViews(display.c_str()); ++i)
        names.emplace_back(config_->config->getView(display.c_str(), i));
    return names;
}

std::string ColorManager::default_display() const {
    return config_->config->getDefaultDisplay();
}

std::string ColorManager::default_view(const std::string& display) const {
    return config_->config->getDefaultView((display.empty() ? default_display() : display).c_str());
}

Result<Matrix3> ColorManager::matrix_to(const std::string& space, const Chromaticities& from) const {
    const Result<Matrix3> from_xyz = config_->from_xyz(space);
    if (!from_xyz) return from_xyz.error();
    const Matrix3 matrix = multiply(*from_xyz, rgb_to_xyz_d65(from));
    double difference = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            difference = std::max(difference, std::abs(matrix[i][j] - (i == j ? 1.0 : 0.0)));
    return difference <= 1e-5 ? identity_matrix() : matrix;
}

Result<Chromaticities> ColorManager::chromaticities(const std::string& space) const {
    const Result<Matrix3> from_xyz = config_->from_xyz(space);
    if (!from_xyz) return from_xyz.error();
    const Matrix3 to_xyz = inverse(*from_xyz);
    for (const Chromaticities& known : {rec709_primaries(), rec2020_primaries(), p3d65_primaries(),
                                        adobe_rgb_primaries(), aces_ap0_primaries(), aces_ap1_primaries()}) {
        const Matrix3 expected = rgb_to_xyz_d65(known);
        double difference = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                difference = std::max(difference, std::abs(to_xyz[i][j] - expected[i][j]));
        // Configs give such matrices to at least four digits; the published sets differ in the second.
        if (difference < 5e-4) return known;
    }
    const auto xy = [&to_xyz](const std::array<double, 3>& colour) {
        const std::array<double, 3> xyz = transform_colour(to_xyz, colour);
        const double sum = xyz[0] + xyz[1] + xyz[2];
        return std::array<double, 2>{xyz[0] / sum, xyz[1] / sum};
    };
    return Chromaticities{xy({1, 0, 0}), xy({0, 1, 0}), xy({0, 0, 1}), xy({1, 1, 1})};
}

Result<FileColor> ColorManager::file_color(const std::string& path, const Chromaticities& to) const {
    const std::string what = "cannot read the colours of '" + path + "'";
    return config_->guarded(what, [&]() -> Result<FileColor> {
        const ocio::ConstConfigRcPtr& config = config_->config;
        FileColor result;
        result.space = config->getColorSpaceFromFilepath(path.c_str());
        result.by_default = config->filepathOnlyMatchesDefaultRule(path.c_str());
        const ocio::ConstColorSpaceRcPtr space = config->getColorSpace(result.space.c_str());
        if (!space) return unknown_name(config_->file, "colour space", result.space, scene_linear_spaces());
        result.is_data = space->isData();
        if (result.is_data) {
            result.convert = [](std::span<float> rgb) {
                for (float& value : rgb)
                    if (!std::isfinite(value)) value = 0;
            };
            return result;
        }
        // A single step in double from the interchange space to the primaries: the processor only linearises.
        const auto processor = config->getProcessor(result.space.c_str(), config_->interchange.c_str())
                                   ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
        const Matrix3 matrix = multiply(inverse(rgb_to_xyz_d65(to)), config_->interchange_to_xyz);
        result.convert = [processor, matrix](std::span<float> rgb) {
            for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
                for (std::size_t c = 0; c < 3; ++c)
                    if (!std::isfinite(rgb[i + c])) rgb[i + c] = 0;
                processor->applyRGB(&rgb[i]);
                const std::array<double, 3> linear = transform_colour(matrix, {rgb[i], rgb[i + 1], rgb[i + 2]});
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto value = static_cast<float>(linear[c]);
                    rgb[i + c] = std::isfinite(value) ? value : 0.0f;
                }
            }
        };
        return result;
    });
}

std::vector<std::string> ColorManager::warnings() const {
    std::vector<std::string> found;
    const ocio::ConstFileRulesRcPtr rules = config_->config->getFileRules();
    for (std::size_t i = 0; i < rules->getNumEntries(); ++i) {
        const char* text = rules->getExtension(i);
        const std::string extension = text != nullptr ? text : "";
        if (extension.find_first_of("()|\\+^$") == std::string::npos) continue;
        found.push_back(config_->file + ": file rule '" + rules->getName(i) + "' has the extension '" + extension +
                        "', which is a glob (* ? [a-z]) and matches no file; expected a 'regex' for alternatives");
    }
    return found;
}

Result<std::vector<unsigned char>> ColorManager::to_display(std::span<const float> rgb, const Chromaticities& primaries,
                                                            const std::string& display, const std::string& view) const {
    if (Status known = check_view(*this, display, view); !known) return std::move(known).error();
    const std::string chosen_display = display.empty() ? default_display() : display;
    const std::string chosen_view = view.empty() ? default_view(chosen_display) : view;

    const std::string what = "cannot apply view '" + chosen_view + "' of display '" + chosen_display + "'";
    return config_->guarded(what, [&]() -> Result<std::vector<unsigned char>> {
        const char* target = config_->config->getDisplayViewColorSpaceName(chosen_display.c_str(), chosen_view.c_str());
        const ocio::ConstColorSpaceRcPtr target_space = config_->config->getColorSpace(target);
        const bool data = target_space && target_space->isData();
        const Matrix3 matrix =
            data ? identity_matrix() : multiply(inverse(config_->interchange_to_xyz), rgb_to_xyz_d65(primaries));

        const auto transform = ocio::DisplayViewTransform::Create();
        transform->setSrc(config_->interchange.c_str());
        transform->setDisplay(chosen_display.c_str());
        transform->setView(chosen_view.c_str());
        const auto processor = config_->config->getProcessor(transform)->getOptimizedCPUProcessor(
            ocio::BIT_DEPTH_F32, ocio::BIT_DEPTH_UINT8, ocio::OPTIMIZATION_DEFAULT);

        const std::size_t pixels = rgb.size() / 3, parts = pixels / 65536 + 1;
        std::vector<unsigned char> result(pixels * 3);
        // ACES views take about 0.2 s per megapixel, so small images get one thread.
        on_threads(parts, 0, [&](std::size_t part) {
            const std::size_t first = pixels * part / parts, last = pixels * (part + 1) / parts;
            constexpr std::size_t strip = 4096;  // pixels; the copy stays in the cache
            std::vector<float> linear(std::min(strip, last - first) * 3);
            for (std::size_t begin = first; begin < last; begin += strip) {
                const std::size_t count = std::min(strip, last - begin);
                for (std::size_t i = 0; i < count; ++i) {
                    std::array<double, 3> colour{};
                    for (std::size_t c = 0; c < 3; ++c) {
                        const float value = rgb[(begin + i) * 3 + c];
                        colour[c] = std::isfinite(value) ? std::clamp(value, -largest_value, largest_value) : 0.0f;
                    }
                    colour = transform_colour(matrix, colour);
                    for (std::size_t c = 0; c < 3; ++c) linear[i * 3 + c] = static_cast<float>(colour[c]);
                }
                const ocio::PackedImageDesc source(linear.data(), static_cast<long>(count), 1,
                                                   ocio::CHANNEL_ORDERING_RGB, ocio::BIT_DEPTH_F32, ocio::AutoStride,
                                                   ocio::AutoStride, ocio::AutoStride);
                ocio::PackedImageDesc target_pixels(result.data() + begin * 3, static_cast<long>(count), 1,
                                                    ocio::CHANNEL_ORDERING_RGB, ocio::BIT_DEPTH_UINT8, ocio::AutoStride,
                                                    ocio::AutoStride, ocio::AutoStride);
                processor->apply(source, target_pixels);
            }
        });
        return result;
    });
}

}  // namespace raylex::display
