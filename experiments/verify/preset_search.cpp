// Finds the splits of a preset in an image.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <string_view>

#include "display/output/reader/exr_layers.h"
#include "display/services/parameters.h"
#include "experiments/verify/presets.h"

namespace raylex::experiments {

namespace {

// Returns the letters and digits in lower case, without the application's prefix "VRay" or "vrayRE_".
std::string plain_name(std::string_view name) {
    std::string lower = lower_case(name);
    for (const std::string_view ahead : {"vrayre_", "vray"})
        if (lower.starts_with(ahead) && lower.size() > ahead.size()) {
            lower.erase(0, ahead.size());
            break;
        }
    std::erase_if(lower, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
    return lower;
}

std::string first_spelling(PassNames names) {
    return std::string(std::string_view(names).substr(0, std::string_view(names).find('|')));
}

std::string choices(PassNames names) {
    std::string text(names);
    for (std::size_t bar = text.find('|'); bar != std::string::npos; bar = text.find('|')) text.replace(bar, 1, " or ");
    return text;
}

std::string quoted(const std::string& name) {
    const char quote = name.find('\'') == std::string::npos ? '\'' : '"';
    return quote + name + quote;
}

// The passes of one view layer, with their common prefix removed.
struct Section {
    std::string name;  // without the trailing dot
    std::vector<std::pair<std::string, const display::ImageLayer*>> passes;

    const display::ImageLayer* find(PassNames names) const {
        std::string_view rest(names);
        while (!rest.empty()) {
            const std::string wanted = plain_name(rest.substr(0, rest.find('|')));
            for (const auto& [pass, layer] : passes)
                if (plain_name(pass) == wanted) return layer;
            rest.remove_prefix(
                std::min(rest.size(), rest.find('|') == std::string_view::npos ? rest.size() : rest.find('|') + 1));
        }
        return nullptr;
    }
};

std::vector<Section> sections_of(const display::ExrImage& image) {
    std::vector<Section> sections;
    const std::string_view shared = display::shared_prefix(image);
    for (const display::ImageLayer& layer : image.layers) {
        std::string_view name = layer.name;
        const std::size_t dot = name.rfind('.');
        const std::string section(dot == std::string_view::npos ? std::string_view() : name.substr(0, dot));
        name.remove_prefix(std::max(dot == std::string_view::npos ? 0 : dot + 1, shared.size()));
        auto found =
            std::find_if(sections.begin(), sections.end(), [&](const Section& each) { return each.name == section; });
        if (found == sections.end()) found = sections.insert(sections.end(), Section{section, {}});
        // A layer without a name can match any name of the beauty.
        found->passes.emplace_back(layer.name.empty() ? "rgba" : std::string(name), &layer);
    }
    return sections;
}

// Builds the formula of one split of one section.
class SplitText {
  public:
    void add(const std::string& name, const std::string& spoken, const char* before, const char* after) {
        text_ += before + quoted(name) + after;
        spoken_ += before + spoken + after;
    }
    void add(const char* between) {
        text_ += between;
        spoken_ += between;
    }
    [[nodiscard]] bool empty() const { return text_.empty(); }
    [[nodiscard]] const std::string& text() const { return text_; }
    [[nodiscard]] const std::string& spoken() const { return spoken_; }

  private:
    std::string text_, spoken_;
};

// Adds the passes of the term that exist. Returns whether it has light.
bool add_term(const PresetTerm& term, const Section& section, SplitText& text, std::vector<std::string>& missing) {
    const auto present = [&section](const std::vector<PassNames>& passes) {
        return std::count_if(passes.begin(), passes.end(),
                             [&section](PassNames pass) { return section.find(pass) != nullptr; });
    };
    const std::vector<PassNames>* chosen = &term.alternatives.front();
    for (const std::vector<PassNames>& passes : term.alternatives) {
        const bool whole = present(passes) == static_cast<std::ptrdiff_t>(passes.size());
        if (present(*chosen) == static_cast<std::ptrdiff_t>(chosen->size())) break;
        if (whole || present(passes) > present(*chosen)) chosen = &passes;
    }
    for (PassNames pass : *chosen)
        if (section.find(pass) == nullptr) missing.push_back(first_spelling(pass));
    const display::ImageLayer* times = term.times == nullptr ? nullptr : section.find(term.times);
    if (term.times != nullptr && times == nullptr) missing.push_back(first_spelling(term.times));
    if (present(*chosen) == 0 || (term.times != nullptr && times == nullptr)) return false;
    if (!text.empty()) text.add(", ");
    const bool brackets = term.times != nullptr && present(*chosen) > 1;
    bool first = true;
    if (brackets) text.add("(");
    for (PassNames pass : *chosen) {
        const display::ImageLayer* layer = section.find(pass);
        if (layer == nullptr) continue;
        text.add(layer->name, first_spelling(pass), first ? "" : " + ", "");
        first = false;
    }
    if (brackets) text.add(")");
    if (times != nullptr) text.add(times->name, first_spelling(term.times), " * ", "");
    return true;
}

// Returns whether the background is transparent: then its light is in a pass, but not in the image.
bool is_transparent(const display::ImageLayer& whole) {
    const display::ImagePlane* alpha = whole.plane("A");
    return alpha != nullptr && std::any_of(alpha->values.begin(), alpha->values.end(), [](float a) { return a < 1; });
}

// Returns the tolerance: float sums of N samples have errors up to N x 2^-24 of the sum; without N, the preset's value.
display::Allowance allowance_of(const Preset& preset, const display::ExrImage& image, const std::string& section) {
    display::Allowance allowance = preset.allowance;
    if (preset.samples_attribute == nullptr) return allowance;
    std::string name = preset.samples_attribute;
    name.replace(name.find('*'), 1, section);
    const auto found = image.attributes.find(name);
    if (found == image.attributes.end()) return allowance;
    const std::string& text = found->second;
    int samples = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), samples);
    constexpr int believable = 1 << 20;
    if (error != std::errc() || end != text.data() + text.size() || samples < 1 || samples > believable)
        return allowance;
    allowance.relative = samples * 0x1p-24;
    allowance.reason = "the float sum of " + text + " samples, 2^-24 each";
    return allowance;
}

// Adds the layers named like the whole, with _ and the name of a group appended.
void add_groups(PassNames groups, const Section& section, SplitText& text) {
    const std::string begin = first_spelling(groups) + "_";
    for (const auto& [pass, layer] : section.passes) {
        if (!pass.starts_with(begin) || plain_name(pass).find("denois") != std::string::npos) continue;
        text.add(layer->name, pass, text.empty() ? "" : ", ", "");
    }
}

}  // namespace

Result<std::vector<FoundSplit>> find_splits(const Preset& preset, const display::ExrImage& image,
                                            const std::string& of) {
    std::vector<FoundSplit> found;
    const std::vector<Section> sections = sections_of(image);
    const display::ImageLayer* given = nullptr;
    if (!of.empty()) {
        Result<const display::ImageLayer*> layer = image.require_layer(of);
        if (!layer) return std::move(layer).error();
        given = *layer;
    }
    bool any_split = false;
    for (const Section& section : sections) {
        const display::ImageLayer* whole = given != nullptr ? given : section.find(preset.whole);
        // Layers in several files: "shot" beside "shot.diffuse".
        if (whole == nullptr && !section.name.empty()) whole = image.layer(section.name);
        if (whole == nullptr) whole = image.layer("");
        for (const PresetSplit& split : preset.splits) {
            SplitText text;
            FoundSplit entry;
            const bool transparent = preset.background != nullptr && whole != nullptr && is_transparent(*whole);
            bool anchored = split.groups != nullptr;
            if (split.groups != nullptr) add_groups(split.groups, section, text);
            for (const PresetTerm& term : split.terms) {
                if (transparent && term.alternatives.front().front() == preset.background) continue;
                if (add_term(term, section, text, entry.missing) && !term.shared) anchored = true;
            }
            if (text.empty() || !anchored) continue;
            const display::ImageLayer* background = transparent ? section.find(preset.background) : nullptr;
            if (background != nullptr) {
                const std::string spoken = first_spelling(preset.background);
                if (split.groups != nullptr) text.add(background->name, spoken, ", -", "");
                entry.note = "the film is transparent (alpha below 1): " + spoken + " is not part of the image";
            }
            any_split = true;
            if (whole == nullptr) continue;
            entry.title = split.title + (section.name.empty() ? std::string() : " of " + section.name);
            entry.of = whole->name;
            entry.allowance = allowance_of(preset, image, section.name);
            entry.sum = text.text();
            entry.formula = text.spoken();
            found.push_back(std::move(entry));
        }
    }
    if (!found.empty()) return found;
    std::string wanted;
    for (const PresetSplit& split : preset.splits)
        for (const PresetTerm& term : split.terms)
            if (!term.shared && std::count(wanted.begin(), wanted.end(), ',') < 6)
                wanted += (wanted.empty() ? "" : ", ") + first_spelling(term.alternatives.front().front());
    return error_at({image.path, 0, 0},
                    any_split
                        ? "the passes of " + std::string(preset.renderer) +
                              " exist, but not the layer that they split; expected a layer " + choices(preset.whole) +
                              ", or --of LAYER; the layers are: " + display::list_names(image.layer_names())
                        : "no layers with names of " + std::string(preset.renderer) + "; expected names such as " +
                              wanted + ", ...; the layers are: " + display::list_names(image.layer_names()));
}

Result<display::SplitResult> check_found(const display::ExrImage& image, const FoundSplit& split,
                                         const std::optional<display::Allowance>& allowance) {
    auto result = display::check_split(image, split.of, {split.sum}, allowance.value_or(split.allowance));
    if (!result) return result;
    result->partition = split.title;
    for (char& c : result->partition)
        if (c == ' ' || c == '/') c = '-';
    return result;
}

bool is_named_after(const Preset& preset, const display::ExrImage& image) {
    const auto splits = find_splits(preset, image, {});
    return splits && std::any_of(splits->begin(), splits->end(), [](const FoundSplit& split) {
               const auto terms = std::count(split.sum.begin(), split.sum.end(), ',') + 1;
               return split.missing.size() < static_cast<std::size_t>(terms);
           });
}

}  // namespace raylex::experiments
