#include "tests/stability/search/random_scene.h"

#include <algorithm>
#include <filesystem>

#include "display/output/atomic_file.h"
#include "experiments/invariants/random.h"
#include "transport/import/builder/scene_builder.h"

namespace raylex::experiments {
namespace {

using namespace transport::typed;
using transport::SceneBuilder;
using transport::ShapePlacement;
using transport::Transform;
using Triple = std::array<double, 3>;

class SceneMaker {
  public:
    SceneMaker(std::uint64_t seed, const std::string& folder)
        : random_(2 * seed + 1), tame_(random_.chance(0.6)), scene_("random-scene", {folder, folder}) {}

    [[nodiscard]] bool tame() const { return tame_; }

    Result<transport::SceneDescription> make() {
        settings();
        media();
        camera();
        textures();
        materials();
        for (std::size_t i = random_.below(3); i > 0; --i) light();
        if (random_.chance(0.5)) sky();
        if (random_.chance(0.3)) object();
        if (tame_ && random_.chance(0.3)) room();
        for (std::size_t i = 1 + random_.below(4); i > 0; --i) thing();
        return scene_.finish();
    }

  private:
    // --- numbers ---

    /// Returns a size, usually ordinary. In wild scenes some sizes have any magnitude that a float can have.
    double size() {
        if (tame_) return std::pow(10.0, random_.between(-1, 0.5));
        const double u = random_.unit();
        const double reach = u < 0.65 ? 0.5 : u < 0.85 ? 6 : u < 0.95 ? 17 : 38;
        return std::pow(10.0, random_.between(-reach, reach));
    }
    double strength() { return random_.chance(0.05) ? 0 : tame_ ? random_.between(0.2, 4) : size(); }
    double signed_size() {
        if (tame_) return random_.between(-2, 2);
        if (random_.chance(0.1)) return 0;
        return random_.chance(0.5) ? size() : -size();
    }
    Triple point() { return {signed_size(), signed_size(), signed_size()}; }
    Triple color(double scale) { return {scale * random_.unit(), scale * random_.unit(), scale * random_.unit()}; }
    /// Returns an albedo, at most 0.95 in tame scenes.
    Triple albedo() {
        if (tame_) return color(random_.chance(0.2) ? 0.95 : 0.9 * random_.unit());
        return color(random_.chance(0.03) ? size() : random_.chance(0.2) ? 1.0 : random_.unit());
    }
    double roughness() {
        if (random_.chance(0.3)) return 0;
        return !tame_ && random_.chance(0.2) ? size() : random_.unit();
    }

    /// Adds an item unless the API rejects it.
    template <typename Outcome>
    static bool kept(const Outcome& outcome) {
        return outcome.ok();
    }

    // --- camera and settings ---

    void settings() {
        kept(scene_.set_film("rgb", {integer("xresolution", static_cast<int>(1 + random_.below(5))),
                                     integer("yresolution", static_cast<int>(1 + random_.below(4)))}));
        const double radius = std::min(random_.chance(0.8) ? random_.between(0.5, 3) : size(), 9.0);
        kept(scene_.set_filter(
            random_.one_of(std::array{"box", "triangle", "gaussian", "mitchell", "sinc", "blackman-harris"}),
            {real("xradius", radius), real("yradius", radius)}));
        kept(scene_.set_sampler(random_.one_of(std::array{"independent", "zsobol", "halton", "stratified"}),
                                sampler_parameters()));
        integrator();
    }
    transport::SceneParameters sampler_parameters() {
        return {integer("pixelsamples", static_cast<int>(1 + random_.below(3)))};
    }
    void integrator() {
        const std::string type =
            random_.one_of(std::array{"path", "path", "path", "volpath", "bdpt", "lighttracer", "pssmlt"});
        std::vector<Parameter> list{
            integer("maxdepth", static_cast<int>(random_.below(!tame_ && random_.chance(0.1) ? 60 : 7)))};
        if (random_.chance(0.2)) list.push_back(boolean("roulette", false));
        if (type == "path" || type == "volpath") {
            if (random_.chance(0.4)) list.push_back(text("strategy", random_.one_of(strategies)));
            if (random_.chance(0.3)) list.push_back(text("lightsampler", "uniform"));
        }
        if (type == "pssmlt") {
            list.push_back(integer("chains", static_cast<int>(1 + random_.below(9))));
            list.push_back(integer("bootstrapsamples", static_cast<int>(1 + random_.below(99))));
        }
        ParameterSet set;
        set.parameters = std::move(list);
        kept(scene_.set_integrator(type, set));
    }
    void media() {
        if (!random_.chance(0.25)) return;
        ParameterSet set;
        set.parameters = {rgb("sigma_a", color(strength())), rgb("sigma_s", color(strength())),
                          real("g", tame_ ? random_.between(-0.7, 0.7) : random_.between(-1, 1))};
        if (random_.chance(0.3)) set.parameters.push_back(rgb("Le", color(strength())));
        const auto fog = scene_.add_medium("fog", "homogeneous", set);
        if (!kept(fog)) return;
        fog_ = *fog;
        if (random_.chance(0.4)) air_ = fog_;
    }
    void camera() {
        const Triple eye = random_.chance(0.7) ? Triple{0, 0, -5} : point(),
                     look = random_.chance(0.8) ? Triple{0, 0, 0} : point();
        Transform view = Transform::look_at(eye, look, {0, 1, 0});
        if (random_.chance(0.1)) view = view * transform();
        double fov = random_.between(20, 100);
        if (!tame_ && random_.chance(0.2)) fov = random_.chance(0.5) ? 179.99999 : 1e-5 * random_.unit();
        ParameterSet set;
        set.parameters = {real("fov", fov)};
        if (random_.chance(0.2)) {
            set.parameters.push_back(real("lensradius", tame_ ? 0.3 * random_.unit() : strength()));
            set.parameters.push_back(real("focaldistance", tame_ ? random_.between(2, 8) : size()));
        }
        if (!tame_ && random_.chance(0.05))
            set.parameters.push_back(numbers("screenwindow", ParameterType::real,
                                             {signed_size(), signed_size(), signed_size(), signed_size()}));
        if (!kept(scene_.set_camera("perspective", set, view, air_)))
            kept(scene_.set_camera("perspective", {}, Transform::look_at({0, 0, -5}, {0, 0, 0}, {0, 1, 0}), air_));
    }

    // --- textures and materials ---

    void textures() {
        for (std::size_t i = random_.below(3); i > 0; --i) {
            const bool spectrum = random_.chance(0.7);
            const std::string name = (spectrum ? "color" : "number") + std::to_string(i);
            ParameterSet set;
            const std::string type =
                random_.one_of(std::array{"constant", "scale", "mix", "checkerboard", "imagemap", "imagemap"});
            const auto value = [&](const std::string& parameter) {
                return spectrum ? rgb(parameter, albedo()) : real(parameter, random_.unit());
            };
            if (type == "constant") set.parameters = {value("value")};
            if (type == "scale") set.parameters = {value("tex"), real("scale", random_.unit())};
            if (type == "mix") set.parameters = {value("tex1"), value("tex2"), real("amount", random_.unit())};
            if (type == "checkerboard") set.parameters = {value("tex1"), value("tex2")};
            if (type == "imagemap")
                set.parameters = {text("filename", "files/noise.pfm"),
                                  text("wrap", random_.one_of(std::array{"repeat", "black", "clamp"})),
                                  text("filter", random_.one_of(std::array{"bilinear", "point"}))};
            if (type == "checkerboard" || type == "imagemap") {
                set.parameters.push_back(
                    text("mapping", random_.one_of(std::array{"uv", "uv", "spherical", "cylindrical", "planar"})));
                set.parameters.push_back(real("uscale", signed_size()));
                set.parameters.push_back(real("vdelta", signed_size()));
            }
            if (!kept(scene_.add_texture(name,
                                         spectrum ? transport::TextureValue::spectrum : transport::TextureValue::real,
                                         type, set, random_.chance(0.5) ? Transform() : transform())))
                continue;
            (spectrum ? colors_ : numbers_).push_back(name);
        }
    }
    Parameter reflectance(const std::string& name) {
        if (!colors_.empty() && random_.chance(0.4)) return texture(name, colors_[random_.below(colors_.size())]);
        return rgb(name, albedo());
    }
    Parameter rough(const std::string& name) {
        if (!numbers_.empty() && random_.chance(0.2)) return texture(name, numbers_[random_.below(numbers_.size())]);
        return real(name, roughness());
    }
    void materials() {
        materials_ = {transport::MaterialHandle{}};
        for (std::size_t i = 1 + random_.below(3); i > 0; --i) {
            const std::string type =
                random_.one_of(std::array{"diffuse", "diffuse", "diffuse", "conductor", "dielectric", "thindielectric",
                                          "coateddiffuse", "coatedconductor", "raylex:additive", "raylex:mirror",
                                          "raylex:diffuse-mirror", "raylex:sheet", "interface"});
            const ParameterSet set = material_parameters(type);
            const auto made = random_.chance(0.5) ? scene_.add_named_material("material" + std::to_string(i), type, set)
                                                  : scene_.add_material(type, set);
            if (kept(made)) materials_.push_back(*made);
        }
        if (random_.chance(0.15)) {
            ParameterSet set;
            set.parameters = {text("materials", "material1"), real("amount", random_.unit())};
            set.parameters[0].strings.emplace_back("material2");
            const bool both = kept(scene_.add_named_material("material1", "diffuse", {})) ||
                              kept(scene_.add_named_material("material2", "conductor", {}));
            static_cast<void>(both);
            if (const auto made = scene_.add_material("mix", set); kept(made) && both) mixes_.push_back(*made);
        }
    }
    ParameterSet material_parameters(const std::string& type) {
        ParameterSet set;
        auto& list = set.parameters;
        if (type == "diffuse" || type == "coateddiffuse") list.push_back(reflectance("reflectance"));
        if (type == "conductor" && random_.chance(0.5)) list.push_back(reflectance("reflectance"));
        if (type == "conductor" || type == "dielectric" || type == "coateddiffuse") {
            if (random_.chance(0.7)) list.push_back(rough("roughness"));
            else list.insert(list.end(), {rough("uroughness"), rough("vroughness")});
            if (random_.chance(0.2)) list.push_back(boolean("remaproughness", false));
        }
        if (type == "dielectric" || type == "thindielectric")
            list.push_back(real("eta", random_.chance(0.8) ? random_.between(0.5, 3) : tame_ ? 1.0001 : size()));
        if (type.starts_with("coated")) {
            if (random_.chance(0.3)) list.push_back(real("thickness", tame_ ? random_.unit() : size()));
            if (random_.chance(0.3))
                list.insert(list.end(), {rgb("albedo", color(1)), real("g", random_.between(-0.9, 0.9))});
        }
        if (type == "raylex:additive" || type == "raylex:diffuse-mirror")
            list.insert(list.end(), {rgb("diffuse", color(0.45)), rgb("specular", color(0.45))});
        if (type == "raylex:mirror") list.push_back(rgb("reflectance", albedo()));
        if (type == "raylex:sheet") list.push_back(rgb("transmittance", albedo()));
        const bool maps = type != "interface" && !type.starts_with("raylex:");
        if (maps && random_.chance(0.1)) list.push_back(text("normalmap", "files/normals.pfm"));
        return set;
    }

    // --- lights ---

    void light() {
        ParameterSet set;
        auto& list = set.parameters;
        const std::string type = random_.one_of(std::array{"point", "spot", "distant"});
        list = {rgb(type == "distant" ? "L" : "I", color(strength()))};
        list.push_back(point3("from", point()));
        if (type != "point") list.push_back(point3("to", point()));
        if (type == "spot")
            list.insert(list.end(), {real("coneangle", random_.between(tame_ ? 20 : 0, 180)),
                                     real("conedeltaangle", random_.between(0, tame_ ? 20 : 90))});
        kept(scene_.add_light(type, set, random_.chance(0.3) ? transform() : Transform()));
    }
    void sky() {
        if (random_.chance(0.7)) {
            kept(scene_.add_light("infinite", {rgb("L", color(strength()))}));
            return;
        }
        kept(scene_.add_light("infinite", {text("filename", "files/noise.pfm"), real("scale", strength())},
                              random_.chance(0.3) ? rotation() : Transform()));
    }

    // --- transforms and shapes ---

    Transform rotation() { return Transform::rotate(random_.between(-720, 720), signed_size(), signed_size(), 1); }
    Transform transform() {
        const auto side = [this] { return random_.chance(0.5) ? 1.0 : -1.0; };
        switch (random_.below(6)) {
            case 0: {
                const Triple by = point();
                return Transform::translate(by[0], by[1], by[2]);
            }
            case 1:
                return Transform::scale(side() * size(), side() * size(), side() * size());
            case 2: {
                const double s = size();
                return Transform::scale(s, s, s);
            }
            case 3:
                return rotation();
            case 4:
                return Transform(matrix());
            default:
                return Transform::translate(random_.between(-2, 2), random_.between(-2, 2), 0);
        }
    }
    /// Returns a matrix with shears and mirroring.
    transport::Matrix4 matrix() {
        transport::Matrix4 m{};
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 4; ++k)
                m[i][k] = !tame_ && random_.chance(0.1) ? signed_size() : random_.between(-2, 2);
        m[3][3] = 1;
        return m;
    }

    void thing() {
        ShapePlacement placement;
        if (random_.chance(0.6)) placement.to_world = transform();
        if (random_.chance(0.2)) placement.to_world = placement.to_world * transform();
        placement.material = material();
        placement.outside = air_;
        placement.inside = air_;
        if (fog_.reference >= 0 && random_.chance(0.4))
            placement.inside = random_.chance(0.7) ? fog_ : transport::MediumHandle{};
        placement.reverse_orientation = random_.chance(0.2);
        if (random_.chance(0.35)) {
            const auto light = scene_.add_area_light(
                "diffuse", {rgb("L", color(strength())), boolean("twosided", random_.chance(0.3))});
            if (kept(light)) placement.area_light = *light;
        }
        shape(placement);
    }
    transport::MaterialHandle material() {
        if (!mixes_.empty() && random_.chance(0.3)) return mixes_.front();
        return materials_[random_.below(materials_.size())];
    }
    /// Adds a closed box around everything, so that paths are long.
    void room() {
        const double s = 8;
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                std::array<Triple, 4> corners{};
                const std::array<std::array<double, 2>, 4> at{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
                std::vector<transport::StoredVec3> positions;
                for (std::size_t i = 0; i < 4; ++i) {
                    Triple& p = corners[i];
                    p[static_cast<std::size_t>(axis)] = side * s;
                    p[static_cast<std::size_t>((axis + 1) % 3)] = at[i][0] * s;
                    p[static_cast<std::size_t>((axis + 2) % 3)] = at[i][1] * s;
                    positions.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
                }
                ShapePlacement placement;
                placement.outside = placement.inside = air_;
                kept(scene_.add_mesh({.positions = positions, .indices = {0, 1, 2, 1, 3, 2}}, placement));
            }
    }
    void object() {
        const auto made = scene_.add_object("it");
        if (!kept(made)) return;
        for (std::size_t i = 1 + random_.below(2); i > 0; --i) {
            ShapePlacement placement;
            placement.object = *made;
            placement.material = material();
            placement.inside = placement.outside = air_;
            if (random_.chance(0.5)) placement.to_world = transform();
            shape(placement);
        }
        for (std::size_t i = 1 + random_.below(3); i > 0; --i) {
            Transform place;
            for (std::size_t k = random_.below(3); k > 0; --k) place = place * transform();
            kept(scene_.add_instance(*made, place));
        }
    }

    void shape(const ShapePlacement& placement) {
        ParameterSet set;
        auto& list = set.parameters;
        const double radius = size();
        switch (random_.below(5)) {
            case 0:
                list = {real("radius", radius)};
                if (random_.chance(0.3))
                    list.insert(list.end(), {real("zmin", radius * random_.between(-2, 2)),
                                             real("zmax", radius * random_.between(-2, 2)),
                                             real("phimax", random_.between(0, 400))});
                return round_shape("sphere", set, placement);
            case 1:
                list = {real("radius", radius), real("height", signed_size()),
                        real("innerradius", random_.chance(0.3) ? radius * random_.between(0, 1.02) : 0)};
                return round_shape("disk", set, placement);
            case 2:
                list = {real("radius", radius), real("zmin", signed_size()), real("zmax", signed_size())};
                return round_shape("cylinder", set, placement);
            default:
                mesh(placement);
        }
    }
    void alpha(ParameterSet& set) {
        if (!random_.chance(0.2)) return;
        if (!numbers_.empty() && random_.chance(0.4)) set.parameters.push_back(texture("alpha", numbers_.front()));
        else set.parameters.push_back(real("alpha", random_.unit()));
    }
    void round_shape(const char* type, ParameterSet& set, const ShapePlacement& placement) {
        alpha(set);
        kept(scene_.add_shape(type, set, placement));
    }
    void mesh(const ShapePlacement& placement) {
        const bool patches = random_.chance(0.4);
        const std::size_t corners = patches ? 4 : 3, count = 1 + random_.below(6);
        const double spread = !tame_ && random_.chance(0.1) ? 0 : size();
        const Triple place = tame_ || random_.chance(0.8) ? Triple{0, 0, 0} : point();
        const bool normals = random_.chance(0.2), uvs = random_.chance(0.4);
        std::vector<double> p, n, uv, indices;
        for (std::size_t i = 0; i < corners * count; ++i) {
            const Triple far = point();
            const bool stray = !tame_ && random_.chance(0.02);
            for (std::size_t k = 0; k < 3; ++k) {
                p.push_back(stray ? far[k] : place[k] + spread * random_.between(-1, 1));
                n.push_back(k == 2 && tame_ ? 3 : signed_size());
                if (k < 2) uv.push_back(signed_size());
            }
            indices.push_back(static_cast<double>(random_.chance(0.9) ? i : random_.below(corners * count)));
        }
        ParameterSet set;
        set.parameters = {numbers("indices", ParameterType::integer, indices), numbers("P", ParameterType::point3, p)};
        if (normals) set.parameters.push_back(numbers("N", ParameterType::normal, n));
        if (uvs) set.parameters.push_back(numbers("uv", ParameterType::point2, uv));
        round_shape(patches ? "bilinearmesh" : "trianglemesh", set, placement);
    }

    static constexpr std::array<const char*, 3> strategies{"mis", "light", "scattering"};
    Random random_;
    bool tame_;
    SceneBuilder scene_;
    transport::MediumHandle fog_, air_;
    std::vector<std::string> colors_, numbers_;
    std::vector<transport::MaterialHandle> materials_, mixes_;
};

/// Returns an 8 x 8 colour image in PFM format.
std::string pfm(const std::function<std::array<float, 3>()>& pixel) {
    std::string bytes = "PF\n8 8\n-1.0\n";
    for (int i = 0; i < 64; ++i)
        for (const float value : pixel()) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return bytes;
}

}  // namespace

Status write_scene_files(const std::string& folder) {
    const std::filesystem::path files = std::filesystem::path(folder) / "files";
    std::error_code failed;
    std::filesystem::create_directories(files, failed);
    if (failed) return error_at({files.string()}, "cannot make this folder: " + failed.message());
    Random random(7);
    const auto unit = [&] { return static_cast<float>(random.between(0.05, 0.9)); };
    const std::array<std::pair<const char*, std::string>, 2> images{{
        {"noise.pfm", pfm([&] {
             return std::array<float, 3>{unit(), unit(), unit()};
         })},
        {"normals.pfm", pfm([&] {
             return std::array<float, 3>{0.5f + 0.2f * (unit() - 0.5f), 0.5f + 0.2f * (unit() - 0.5f), 0.95f};
         })},
    }};
    for (const auto& [name, bytes] : images) {
        auto file = display::AtomicFile::create((files / name).string(), display::FileSync::later);
        if (!file) return file.error();
        if (!file->write(bytes.data(), bytes.size())) return file->failure();
        if (Status status = file->commit(); !status) return status;
    }
    return success();
}

Result<RandomScene> random_scene(std::uint64_t seed, const std::string& folder) {
    SceneMaker maker(seed, folder);
    Result<transport::SceneDescription> scene = maker.make();
    if (!scene) return scene.error();
    return RandomScene{maker.tame(), std::move(*scene)};
}

}  // namespace raylex::experiments
