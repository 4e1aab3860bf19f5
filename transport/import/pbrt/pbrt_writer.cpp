#include "transport/import/pbrt/pbrt_writer.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>

#include "display/output/atomic_file.h"
#include "transport/import/pbrt/pbrt_values.h"

namespace raylex::transport {

namespace {

namespace fs = std::filesystem;

constexpr const char* name_of_color_space[] = {"srgb", "dci-p3", "rec2020", "aces2065-1"};
constexpr std::size_t most_blocks = 64;  ///< nesting depth of blocks: far below the limit of readers

/// Writes shapes inside AttributeBegin blocks that set their common attributes.
class PbrtWriter {
  public:
    PbrtWriter(const SceneDescription& scene, std::string mesh_folder)
        : scene_(scene), mesh_folder_(std::move(mesh_folder)) {
        find_uses();
    }

    PbrtText write() {
        head();
        for (const SceneTexture& texture : scene_.textures)
            under(texture.to_world, "Texture " + quoted(texture.name) +
                                        (texture.spectrum ? " \"spectrum\" " : " \"float\" ") + quoted(texture.type) +
                                        parameters_text(texture.parameters));
        for (const SceneLight& light : scene_.lights) {
            under(light.to_world, "LightSource " + quoted(light.type) + parameters_text(light.parameters));
            if (!light.group.empty()) leave_out("groups of lights");
        }
        content();
        write_materials(scene_.materials.size());
        if (written_lights_ < scene_.area_lights.size()) {
            line("AttributeBegin");
            write_area_lights(scene_.area_lights.size());
            line("AttributeEnd");
        }
        for (const SceneInstance& instance : scene_.instances) {
            const std::string directive =
                "ObjectInstance " + quoted(scene_.objects[static_cast<std::size_t>(instance.object)].name);
            if (instance.motion < 0) under(instance.to_world, directive);
            else under_motion(instance, directive);
            if (!instance.label.empty()) leave_out("labels of instances");
            if (instance.holdout) leave_out("holdouts");
        }
        return std::move(result_);
    }

  private:
    enum class User : std::uint8_t { none, object, scene };
    /// The attribute that a block sets.
    struct Setting {
        int material = -1, area_light = -1;  // one of the two is set
    };
    struct State {
        int material = 0, area_light = -1;
        bool operator==(const State&) const = default;
    };

    void line(const std::string& text) { (result_.text += text) += '\n'; }
    void leave_out(const std::string& what) {
        const std::string sentence = what + " cannot be written to pbrt files and are omitted";
        if (std::find(result_.left_out.begin(), result_.left_out.end(), sentence) == result_.left_out.end())
            result_.left_out.push_back(sentence);
    }
    void under(const Transform& transform, const std::string& directive) {
        if (transform.is_identity()) return line(directive);
        line("AttributeBegin");
        line("Transform " + matrix_text(transform.matrix()));
        line(directive);
        line("AttributeEnd");
    }
    void under_motion(const SceneInstance& instance, const std::string& directive) {
        line("AttributeBegin");
        line("Transform " + matrix_text(instance.to_world.matrix()));
        line("ActiveTransform EndTime");
        line("Transform " + matrix_text(scene_.moved_to[static_cast<std::size_t>(instance.motion)].matrix()));
        line("ActiveTransform All");
        line(directive);
        line("AttributeEnd");
    }
    void entity(const char* directive, const SceneEntity& entity) {
        if (!entity.type.empty())
            line(std::string(directive) + " " + quoted(entity.type) + parameters_text(entity.parameters));
    }
    [[nodiscard]] std::string medium_name(int index) const {
        return quoted(index < 0 ? std::string() : scene_.media[static_cast<std::size_t>(index)].name);
    }

    void head() {
        if (scene_.color.scene_space != ColorSpace::srgb) {
            line("ColorSpace " + quoted(name_of_color_space[static_cast<std::size_t>(scene_.color.scene_space)]));
            if (scene_.film.type.empty()) line("Film \"rgb\"");  // readers take the scene's colour space at its film
        }
        entity("Film", scene_.film);
        entity("PixelFilter", scene_.filter);
        entity("Sampler", scene_.sampler);
        entity("Integrator", scene_.integrator);
        for (const SceneMedium& medium : scene_.media) {
            const bool placed = !medium.to_world.is_identity();
            if (placed) line("Transform " + matrix_text(medium.to_world.matrix()));
            line("MakeNamedMedium " + quoted(medium.name) + " \"string type\" " + quoted(medium.type) +
                 parameters_text(medium.parameters));
            if (placed) line("Identity");
        }
        if (scene_.camera_medium >= 0) line("MediumInterface \"\" " + medium_name(scene_.camera_medium));
        if (scene_.transform_times != std::array<double, 2>{0, 1}) {
            std::string text = "TransformTimes ";
            for (const double time : scene_.transform_times) append_number(text, time);
            line(text);
        }
        if (!scene_.camera.type.empty()) {
            camera_place(scene_.camera_to_world);
            if (scene_.camera_moved_to) {
                line("ActiveTransform EndTime");
                if (scene_.camera_moved_to->is_identity()) line("Identity");
                camera_place(*scene_.camera_moved_to);
                line("ActiveTransform All");
            }
            entity("Camera", scene_.camera);
        }
        line("WorldBegin");
    }

    /// Writes a linear map after a translation, as SceneBuilder stores it, so that the camera's place is exact.
    void camera_place(const Transform& camera_to_world) {
        Matrix4 matrix = camera_to_world.inverse().matrix();
        const Matrix4& place = camera_to_world.matrix();
        if (camera_to_world.is_identity()) return;
        const std::array<double, 4> last{0, 0, 0, 1};
        const bool affine = matrix[3] == last && place[3] == last;
        if (affine)
            for (std::size_t i = 0; i < 3; ++i) matrix[i][3] = 0;
        line("Transform " + matrix_text(matrix));
        if (!affine) return;
        std::string text = "Translate ";
        for (std::size_t i = 0; i < 3; ++i) append_number(text, -place[i][3]);
        line(text);
    }

    // --- the current material and area light ---

    [[nodiscard]] bool is_named(int material) const {
        return !scene_.materials[static_cast<std::size_t>(material)].name.empty();
    }
    void write_materials(std::size_t end) {
        for (; written_materials_ < end; ++written_materials_) write_material(written_materials_);
    }
    void write_material(std::size_t index) {
        const SceneEntity& material = scene_.materials[index];
        if (material.name.empty()) return entity("Material", material);
        line("MakeNamedMaterial " + quoted(material.name) + " \"string type\" " + quoted(material.type) +
             parameters_text(material.parameters));
    }
    void write_area_lights(std::size_t end) {
        for (; written_lights_ < end; ++written_lights_) write_area_light(written_lights_);
    }
    void write_area_light(std::size_t index) {
        entity("AreaLightSource", scene_.area_lights[index]);
        if (!scene_.area_lights[index].group.empty()) leave_out("groups of lights");
    }

    void find_uses() {
        users_.resize(scene_.materials.size(), User::none);
        for (const SceneObject& object : scene_.objects)
            for (const SceneShape& shape : object.shapes)
                users_[static_cast<std::size_t>(shape.material)] = User::object;
        for (const SceneShape& shape : scene_.shapes) users_[static_cast<std::size_t>(shape.material)] = User::scene;
        for (std::size_t i = 0; i < scene_.shapes.size(); ++i) {
            last_material_[scene_.shapes[i].material] = i;
            last_light_[scene_.shapes[i].area_light] = i;
        }
    }
    [[nodiscard]] bool needed(const Setting& setting, std::size_t shape) const {
        const auto& uses = setting.material >= 0 ? last_material_ : last_light_;
        const auto found = uses.find(setting.material >= 0 ? setting.material : setting.area_light);
        return found != uses.end() && found->second >= shape;
    }
    [[nodiscard]] State state_below(std::size_t blocks) const {
        State state;
        for (std::size_t i = 0; i < blocks; ++i)
            if (blocks_[i].material >= 0) state.material = blocks_[i].material;
            else state.area_light = blocks_[i].area_light;
        return state;
    }
    /// Whether opening blocks leads from `state` to `wanted`; `once`: without writing anything a second time.
    [[nodiscard]] bool reaches(const State& state, const State& wanted, bool once) const {
        if (wanted.area_light < 0 && state.area_light >= 0) return false;
        if (wanted.material == 0 && state.material != 0) return false;
        if (!once) return true;
        const bool fresh_light =
            wanted.area_light == state.area_light || static_cast<std::size_t>(wanted.area_light) >= written_lights_;
        return fresh_light && (wanted.material == state.material || is_named(wanted.material) ||
                               static_cast<std::size_t>(wanted.material) >= written_materials_);
    }
    void close_blocks(std::size_t left) {
        for (; blocks_.size() > left; blocks_.pop_back()) line("AttributeEnd");
    }

    void settle(const State& wanted, std::size_t shape) {
        while (!blocks_.empty() && (!needed(blocks_.back(), shape) || blocks_.size() > most_blocks))
            close_blocks(blocks_.size() - 1);
        std::size_t keep = blocks_.size() + 1;
        for (const bool once : {true, false}) {
            if (keep <= blocks_.size()) break;
            for (std::size_t blocks = blocks_.size() + 1; blocks-- > 0;)
                if (reaches(state_below(blocks), wanted, once)) {
                    keep = blocks;
                    break;
                }
        }
        close_blocks(keep);
        const State now = state_below(keep);
        if (now.material != wanted.material) {
            line("AttributeBegin");
            blocks_.push_back({wanted.material, -1});
            set_material(static_cast<std::size_t>(wanted.material));
        }
        if (now.area_light != wanted.area_light) {
            line("AttributeBegin");
            blocks_.push_back({-1, wanted.area_light});
            const auto index = static_cast<std::size_t>(wanted.area_light);
            if (index < written_lights_) write_area_light(index);
            else write_area_lights(index + 1);
        }
    }
    void set_material(std::size_t index) {
        if (is_named(static_cast<int>(index))) line("NamedMaterial " + quoted(scene_.materials[index].name));
        else if (index < written_materials_) write_material(index);
        else write_materials(index + 1);
    }

    // --- shapes ---

    void shape(const SceneShape& shape) {
        const Transform& transform = shape.object_to_world;
        const bool reverse = shape.flip_normal != transform.swaps_handedness();
        const bool same_media = shape.inside_medium == -1 && shape.outside_medium == scene_.camera_medium;
        const bool block = reverse || !same_media || !transform.is_identity();
        if (block) line("AttributeBegin");
        if (!same_media)
            line("MediumInterface " + medium_name(shape.inside_medium) + " " + medium_name(shape.outside_medium));
        if (reverse) line("ReverseOrientation");
        if (!transform.is_identity()) line("Transform " + matrix_text(transform.matrix()));
        if (shape.kind == ShapeKind::curves)
            for (std::size_t i = 0; i < shape.indices.size(); ++i) line("Shape " + curve_text(shape, i));
        else line("Shape " + (shape.source_file.empty() ? shape_text(shape, reverse) : mesh_file_text(shape, reverse)));
        if (block) line("AttributeEnd");
        if (shape.label != scene_.materials[static_cast<std::size_t>(shape.material)].name)
            leave_out("labels other than materials' names");
        if (shape.holdout) leave_out("holdouts");
    }
    std::string mesh_file_text(const SceneShape& shape, bool reverse) {
        const std::string path = mesh_folder_ + "/" + std::to_string(result_.meshes.size()) + "/" + shape.source_file;
        result_.meshes.push_back({path, ply_content(shape, reverse)});
        return "\"plymesh\" \"string filename\" " + quoted(path) + displacement_text(shape) + alpha_text(shape);
    }

    /// Whether the next material without a name that has not been written belongs to an object.
    bool object_brings_next() {
        std::size_t& next = next_material_;
        next = std::max(next, written_materials_);
        while (next < users_.size() && (users_[next] == User::none || is_named(static_cast<int>(next)))) ++next;
        return next == users_.size() || users_[next] == User::object;
    }
    /// Whether the material has been written, so that a reference by name is enough.
    [[nodiscard]] bool is_ready(int material) const {
        return is_named(material) || static_cast<std::size_t>(material) < written_materials_;
    }
    /// Writes objects and shapes, in an order that keeps the order of materials if possible.
    void content() {
        written_materials_ = 1;  // [0] is part of every scene
        std::size_t next_object = 0, next_shape = 0;
        const auto& [objects, shapes] = std::tie(scene_.objects, scene_.shapes);
        while (next_object < objects.size() || next_shape < shapes.size()) {
            const bool object =
                next_shape == shapes.size() ||
                (next_object < objects.size() && !is_ready(shapes[next_shape].material) && object_brings_next());
            if (object) {
                write_object(objects[next_object++]);
                continue;
            }
            const SceneShape& next = shapes[next_shape];
            settle({next.material, next.area_light}, next_shape++);
            shape(next);
        }
        close_blocks(0);
    }
    void write_object(const SceneObject& object) {
        close_blocks(0);
        line("ObjectBegin " + quoted(object.name));
        int material = 0;
        bool block = false;
        for (const SceneShape& each : object.shapes) {
            if (each.material != material) {
                if (block) line("AttributeEnd");
                block = each.material != 0;
                if (block) line("AttributeBegin");
                if (block) set_material(static_cast<std::size_t>(each.material));
                material = each.material;
            }
            shape(each);
        }
        if (block) line("AttributeEnd");
        line("ObjectEnd");
    }

    const SceneDescription& scene_;
    std::string mesh_folder_;
    PbrtText result_;
    std::map<int, std::size_t> last_material_, last_light_;  ///< the last shape of the scene that uses it
    std::vector<User> users_;                                ///< [material] the owner of the shapes that use it
    std::vector<Setting> blocks_;                            ///< open around the next shape
    std::size_t written_materials_ = 0, written_lights_ = 0, next_material_ = 0;
};

Status write_file(const fs::path& path, const std::string& content) {
    Result<display::AtomicFile> file = display::AtomicFile::create(path.string());
    if (!file) return file.error();
    if (!file->write(content.data(), content.size())) return file->failure();
    return file->commit();
}

}  // namespace

PbrtText pbrt_text(const SceneDescription& scene, const std::string& mesh_folder) {
    return PbrtWriter(scene, mesh_folder).write();
}

Result<std::vector<std::string>> write_pbrt(const SceneDescription& scene, const std::string& path) {
    const fs::path file(path), folder = fs::path(file).replace_extension("meshes").filename();
    PbrtText written = pbrt_text(scene, folder.string());
    for (const PbrtText::MeshFile& mesh : written.meshes) {
        const fs::path target = file.parent_path() / mesh.path;
        std::error_code failed;
        fs::create_directories(target.parent_path(), failed);
        if (failed) {
            Error error;
            error.file = target.parent_path().string();
            error.message = "the folder cannot be made: " + failed.message();
            return error;
        }
        if (Status status = write_file(target, mesh.content); !status) return status.error();
    }
    if (Status status = write_file(file, written.text); !status) return status.error();
    return std::move(written.left_out);
}

}  // namespace raylex::transport
