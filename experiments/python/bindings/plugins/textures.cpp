// Textures in Python: patterns (transport/textures/pattern.h) that evaluate a batch of hits at once.
#include <cstring>
#include <unordered_map>

#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/plugins/plugin_parts.h"
#include "experiments/python/bindings/plugins/python_object.h"
#include "experiments/python/bindings/plugins/services.h"
#include "transport/textures/pattern.h"

namespace raylex::python {

using transport::Rgb;
using transport::TexturePoint;

namespace {

/// The place of a look-up: everything that a texture may depend on, bit by bit.
struct Place {
    std::array<std::uint32_t, 8> bits{};
    explicit Place(const TexturePoint& at) {
        const float numbers[] = {transport::to_float(at.u),          transport::to_float(at.v),
                                 transport::to_float(at.position.x), transport::to_float(at.position.y),
                                 transport::to_float(at.position.z), transport::to_float(at.normal.x),
                                 transport::to_float(at.normal.y),   transport::to_float(at.normal.z)};
        std::memcpy(bits.data(), numbers, sizeof numbers);
    }
    bool operator==(const Place&) const = default;
};
struct PlaceHash {
    std::size_t operator()(const Place& place) const {
        std::size_t hash = 0;
        for (const std::uint32_t each : place.bits) hash = (hash ^ each) * 0x9e3779b97f4a7c15ULL;
        return hash ^ hash >> 29;
    }
};

class PythonTexture final : public transport::Pattern {
  public:
    PythonTexture(std::string name, py::object object, bool spectrum, const transport::Transform& from_render)
        : name_(std::move(name)),
          object_(std::move(object)),
          spectrum_(spectrum),
          from_render_(from_render),
          control_(RunControl::current()) {
        static std::atomic<std::uint64_t> made{0};
        number_ = ++made;
    }

    [[nodiscard]] Rgb rgb(const transport::PatternPoint& point) const override { return value(point.at); }
    [[nodiscard]] transport::Real real(const transport::PatternPoint& point) const override {
        return value(point.at).r;
    }
    [[nodiscard]] bool looks_ahead() const override { return true; }
    void look_ahead(std::span<const TexturePoint> points) const override {
        if (known_here().size() > most_kept) known_here().clear();  // removes entries of textures of earlier renders
        Known& known = known_here()[number_];
        known.clear();
        const std::vector<Rgb> values = evaluate(points);
        for (std::size_t i = 0; i < values.size(); ++i) known.emplace(Place(points[i]), values[i]);
    }

  private:
    using Known = std::unordered_map<Place, Rgb, PlaceHash>;
    static constexpr std::size_t most_kept = 64;
    /// Values known in this thread, by index of the texture.
    static std::unordered_map<std::uint64_t, Known>& known_here() {
        thread_local std::unordered_map<std::uint64_t, Known> known;
        return known;
    }

    [[nodiscard]] Rgb value(const TexturePoint& at) const {
        const Known& known = known_here()[number_];
        const auto found = known.find(Place(at));
        if (found != known.end()) return found->second;
        const std::vector<Rgb> values = evaluate({&at, 1});
        return values.empty() ? Rgb() : values.front();
    }

    /// Returns an empty vector if the render has failed.
    [[nodiscard]] std::vector<Rgb> evaluate(std::span<const TexturePoint> points) const {
        std::vector<Rgb> values;
        if (points.empty()) return values;
        guarded_call(control_, [&] {
            std::vector<float> uv, position, normal;
            for (const TexturePoint& each : points) {
                const transport::Vec3 p = from_render_.point(each.position);
                uv.insert(uv.end(), {transport::to_float(each.u), transport::to_float(each.v)});
                position.insert(position.end(),
                                {transport::to_float(p.x), transport::to_float(p.y), transport::to_float(p.z)});
                normal.insert(normal.end(), {transport::to_float(each.normal.x), transport::to_float(each.normal.y),
                                             transport::to_float(each.normal.z)});
            }
            const auto count = static_cast<py::ssize_t>(points.size());
            const auto services = std::make_shared<TextureServices>(points);
            const std::unique_ptr<TextureServices, void (*)(TextureServices*)> ends(
                services.get(), [](TextureServices* s) { s->end(); });
            const py::object at = py::module_::import("raylex.plugins")
                                      .attr("TexturePoints")(owning_array(std::move(uv), {count, 2}),
                                                             owning_array(std::move(position), {count, 3}),
                                                             owning_array(std::move(normal), {count, 3}), services);
            const Array<float> result =
                array_of<float>((*object_).attr("evaluate")(at), "the result of texture '" + name_ + "'");
            check_shape(result, points.size(), spectrum_ ? 3 : 0, "the result of texture '" + name_ + "'");
            for (std::size_t i = 0; i < points.size(); ++i) {
                const float* const v = result.data() + i * (spectrum_ ? 3 : 1);
                values.push_back(spectrum_ ? Rgb(v[0], v[1], v[2]) : Rgb(v[0]));
            }
        });
        return values;
    }

    std::string name_;
    Held object_;
    bool spectrum_;
    transport::Transform from_render_;
    std::shared_ptr<RunControl> control_;
    std::uint64_t number_ = 0;
};

void register_texture(const std::string& name, const py::object& type, const std::string& help,
                      const py::dict& defaults) {
    auto& registry = transport::pattern_registry();
    const auto python = describe_class("texture", name, help, type, defaults);
    claim_name("texture", name, registry.find(name) != nullptr);
    registry.add({name, help, python->parameters,
                  [python](transport::PatternReader& reader) -> Result<std::unique_ptr<transport::Pattern>> {
                      const Callback locked;
                      auto object = make_instance(*python, reader);
                      if (!object) return object.error();
                      return std::unique_ptr<transport::Pattern>(
                          std::make_unique<PythonTexture>(python->name, *std::move(object), reader.texture.spectrum,
                                                          reader.texture.to_world.inverse()));
                  }});
}

}  // namespace

void add_textures(py::module_& module) {
    using namespace pybind11::literals;
    module.def("_register_texture", &register_texture, "name"_a, "type"_a, "help"_a, "defaults"_a);
}

}  // namespace raylex::python
