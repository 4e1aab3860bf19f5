// Labels and light groups by rule. A rule that selects nothing is probably a mistake, so it is an error. A rule that
// selects only objects that earlier rules labelled is legal (a catch-all at the end) and adds a warning.
#include "transport/scene/scene_description.h"

#include <algorithm>
#include <map>
#include <set>

#include "lpe/language/glob.h"

namespace raylex::transport {

namespace {

using Selector = LabelRule::Selector;

const char* selector_name(Selector selector) {
    switch (selector) {
        case Selector::material:
            return "material";
        case Selector::mesh_file:
            return "mesh file";
        case Selector::instance:
            return "instance";
        case Selector::light:
            return "light";
        case Selector::area_light_material:
            return "area light's material";
    }
    return "";
}

/// The names "spot" and "spot:1" for every light, in file order per kind; area lights have the kind "area".
struct LightNames {
    std::vector<std::string> kinds, indexed;
};

LightNames light_names(const SceneDescription& scene) {
    LightNames names;
    std::map<std::string, int> count;
    const auto add = [&](const std::string& kind) {
        names.kinds.push_back(kind);
        names.indexed.push_back(kind + ":" + std::to_string(count[kind]++));
    };
    for (const SceneLight& light : scene.lights) add(light.type);
    for (std::size_t i = 0; i < scene.area_lights.size(); ++i) add("area");
    return names;
}

/// Applies rules to one scene: finds the objects that each rule selects, and sets the label where no earlier rule did.
class RuleApplier {
  public:
    explicit RuleApplier(SceneDescription& scene)
        : scene_(scene), lights_(light_names(scene)), light_taken_(lights_.kinds.size()) {
        for_each_shape([this](SceneShape&) { shape_taken_.emplace_back(); });
        instance_taken_.resize(scene.instances.size());
        std::map<int, int> count;
        for (const SceneInstance& instance : scene.instances) {
            const std::string& name = scene.objects[static_cast<std::size_t>(instance.object)].name;
            instance_names_.push_back({name, name + ":" + std::to_string(count[instance.object]++)});
        }
    }

    Status apply(const LabelRule& rule) {
        pattern_ = rule.pattern;
        matched_ = written_ = 0;
        candidates_.clear();
        switch (rule.selector) {
            case Selector::material:
            case Selector::mesh_file:
                apply_to_shapes(rule);
                break;
            case Selector::instance:
                apply_to_instances(rule);
                break;
            case Selector::light:
                apply_to_lights(rule);
                break;
            case Selector::area_light_material:
                apply_to_emitters(rule);
                break;
        }
        if (matched_ == 0) return nothing_matched(rule);
        if (written_ == 0)
            scene_.warnings.push_back(
                error_at(rule.location, "label rule '" + rule.pattern + "' selects only what earlier rules labelled"));
        return success();
    }

  private:
    template <class Visit>
    void for_each_shape(Visit visit) {
        for (SceneShape& shape : scene_.shapes) visit(shape);
        for (SceneObject& object : scene_.objects)
            for (SceneShape& shape : object.shapes) visit(shape);
    }

    const std::string& material_name(const SceneShape& shape) const {
        return scene_.materials[static_cast<std::size_t>(shape.material)].name;
    }

    bool matches(const std::string& name) {
        if (!name.empty()) candidates_.insert(name);
        return !name.empty() && lpe::glob_matches(pattern_, name);
    }

    /// The results of earlier rules for an object or a light.
    struct Taken {
        bool label = false, holdout = false;
    };

    void write(Taken& taken, std::string& target, const LabelRule& rule) {
        ++matched_;
        if (rule.keeps_label || taken.label) return;
        taken.label = true;
        target = rule.label;
        ++written_;
    }
    template <class Target>
    void write(Taken& taken, Target& target, const LabelRule& rule) {
        write(taken, target.label, rule);
        if (!rule.holdout || taken.holdout) return;
        taken.holdout = true;
        target.holdout = *rule.holdout;
        ++written_;
    }

    void apply_to_shapes(const LabelRule& rule) {
        std::size_t index = 0;
        for_each_shape([&](SceneShape& shape) {
            const std::string& name = rule.selector == Selector::material ? material_name(shape) : shape.source_file;
            if (matches(name)) {
                write(shape_taken_[index], shape, rule);
                shape.labelled = shape_taken_[index].label;
            }
            ++index;
        });
    }

    void apply_to_instances(const LabelRule& rule) {
        for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
            const bool whole = matches(instance_names_[i].first), one = matches(instance_names_[i].second);
            if (whole || one) write(instance_taken_[i], scene_.instances[i], rule);
        }
    }

    std::string& group(std::size_t light) {
        return light < scene_.lights.size() ? scene_.lights[light].group
                                            : scene_.area_lights[light - scene_.lights.size()].group;
    }

    void apply_to_lights(const LabelRule& rule) {
        for (std::size_t i = 0; i < lights_.kinds.size(); ++i) {
            const bool kind = matches(lights_.kinds[i]), one = matches(lights_.indexed[i]);
            if (kind || one) write(light_taken_[i], group(i), rule);
        }
    }

    void apply_to_emitters(const LabelRule& rule) {
        for_each_shape([&](SceneShape& shape) {
            if (shape.area_light < 0 || !matches(material_name(shape))) return;
            const std::size_t light = scene_.lights.size() + static_cast<std::size_t>(shape.area_light);
            write(light_taken_[light], group(light), rule);
        });
    }

    Error nothing_matched(const LabelRule& rule) const {
        const std::vector<std::string> known(candidates_.begin(), candidates_.end());
        std::string hint;
        if (const std::string near = nearest_name(rule.pattern, known); !near.empty())
            hint = "did you mean '" + near + "'? ";
        constexpr std::size_t most = 20;
        hint += known.empty() ? std::string("the scene has none") : "the scene has:";
        for (std::size_t i = 0; i < std::min(known.size(), most); ++i) hint += " " + known[i];
        if (known.size() > most) hint += " and " + std::to_string(known.size() - most) + " more";
        const bool of_lights = rule.selector == Selector::light || rule.selector == Selector::area_light_material;
        const bool by_material = rule.selector == Selector::material || rule.selector == Selector::area_light_material;
        if (known.empty() && by_material)
            return error_at(rule.location,
                            "label rule matches nothing: '" + rule.pattern + "' is matched against materials' names, " +
                                "and no shape of the scene has a material with a name",
                            "files name them by MakeNamedMaterial, code by the `name` of a material");
        return error_at(rule.location,
                        (of_lights ? "light group" : "label") + std::string(" rule matches nothing: no ") +
                            selector_name(rule.selector) + " is called '" + rule.pattern + "'",
                        hint);
    }

    SceneDescription& scene_;
    LightNames lights_;
    std::vector<Taken> shape_taken_, instance_taken_, light_taken_;
    std::vector<std::pair<std::string, std::string>> instance_names_;
    std::string pattern_;
    std::set<std::string> candidates_;
    std::size_t matched_ = 0, written_ = 0;
};

}  // namespace

Status apply_label_rules(SceneDescription& scene, const std::vector<LabelRule>& rules) {
    RuleApplier applier(scene);
    for (const LabelRule& rule : rules)
        if (Status status = applier.apply(rule); !status) return status;
    return success();
}

}  // namespace raylex::transport
