#include "transport/import/pbrt/pbrt_values.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstring>

namespace raylex::transport {

namespace {

template <typename Number>
void append_shortest(std::string& text, Number value) {
    std::array<char, 40> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    text.append(buffer.data(), end.ptr).push_back(' ');
}

template <typename Item, typename Append>
std::string list_text(const char* declaration, const std::vector<Item>& items, const Append& append) {
    if (items.empty()) return {};
    std::string text = std::string(" \"") + declaration + "\" [ ";
    for (const Item& item : items) append(text, item);
    return text + "]";
}

void append_vector(std::string& text, const StoredVec3& v) {
    for (const float x : {v.x, v.y, v.z}) append_number(text, x);
}

std::string number_parameter(const char* name, double value) {
    std::string text = std::string(" \"float ") + name + "\" ";
    append_number(text, value);
    text.pop_back();
    return text;
}

StoredVec3 as_written(const StoredVec3& normal, bool reverse_orientation) {
    return reverse_orientation ? -normal : normal;
}

std::string mesh_text(const SceneShape& shape, bool reverse_orientation) {
    return list_text("integer indices", shape.indices,
                     [](std::string& text, std::uint32_t i) { text += std::to_string(i) + " "; }) +
           list_text("point3 P", shape.positions, append_vector) +
           list_text("normal N", shape.normals,
                     [&](std::string& text, const StoredVec3& n) {
                         append_vector(text, as_written(n, reverse_orientation));
                     }) +
           list_text("point2 uv", shape.uvs, [](std::string& text, const StoredVec2& uv) {
               append_number(text, uv.x);
               append_number(text, uv.y);
           });
}

template <typename Number>
void append_bytes(std::string& bytes, Number number) {
    static_assert(std::endian::native == std::endian::little);
    std::array<char, sizeof number> raw{};
    std::memcpy(raw.data(), &number, sizeof number);
    bytes.append(raw.data(), raw.size());
}

}  // namespace

void append_number(std::string& text, double value) {
    append_shortest(text, value);
}

// Readers parse a double and then round it to float. The shortest digits of a float that lie next to the middle between
// two floats would be rounded twice.
void append_number(std::string& text, float value) {
    const std::size_t start = text.size();
    append_shortest(text, value);
    double read = 0;
    std::from_chars(text.data() + start, text.data() + text.size(), read);
    if (static_cast<float>(read) == value) return;
    text.resize(start);
    append_number(text, static_cast<double>(value));
}

std::string quoted(const std::string& text) {
    constexpr std::string_view letters = "bfnrt\\\"", meanings = "\b\f\n\r\t\\\"";
    std::string result = "\"";
    for (const char c : text) {
        const std::size_t which = meanings.find(c);
        if (which == std::string_view::npos) result += c;
        else (result += '\\') += letters[which];
    }
    return result + "\"";
}

std::string matrix_text(const Matrix4& matrix) {
    std::string text = "[ ";
    for (std::size_t i = 0; i < 16; ++i) append_number(text, matrix[i % 4][i / 4]);
    return text + "]";
}

std::string parameters_text(const ParameterSet& set) {
    std::string text;
    for (const Parameter& parameter : set.parameters) {
        text += " " + quoted(std::string(type_name(parameter.type)) + " " + parameter.name) + " [ ";
        for (const double number : parameter.numbers) append_number(text, number);
        for (const std::string& each : parameter.strings) text += quoted(each) + " ";
        for (const std::uint8_t each : parameter.booleans) text += each != 0 ? "true " : "false ";
        text += "]";
    }
    return text;
}

std::string alpha_text(const SceneShape& shape) {
    if (!shape.alpha_texture.empty()) return " \"texture alpha\" " + quoted(shape.alpha_texture);
    return shape.alpha == 1 ? std::string() : number_parameter("alpha", double{shape.alpha});
}

std::string displacement_text(const SceneShape& shape) {
    // An edge length without displacement has no effect, but the scene that is read back is identical in every field.
    const std::string edge = shape.edge_length == 1 ? "" : number_parameter("edgelength", double{shape.edge_length});
    if (shape.displacement_texture.empty()) return edge;
    return " \"texture displacement\" " + quoted(shape.displacement_texture) + edge;
}

std::string curve_text(const SceneShape& shape, std::size_t number) {
    constexpr const char* types[] = {"flat", "cylinder", "ribbon"};
    const std::size_t begin = shape.indices[number];
    const std::size_t end = number + 1 < shape.indices.size() ? shape.indices[number + 1] : shape.positions.size();
    const auto part = [](const std::vector<StoredVec3>& list, std::size_t from, std::size_t to) {
        return std::vector<StoredVec3>(list.begin() + static_cast<std::ptrdiff_t>(from),
                                       list.begin() + static_cast<std::ptrdiff_t>(to));
    };
    std::string text = "\"curve\" \"string type\" " + quoted(types[static_cast<std::size_t>(shape.curve_type)]) +
                       list_text("point3 P", part(shape.positions, begin, end), append_vector);
    if (!shape.normals.empty()) {
        const std::size_t first = (begin - number) / 3 + number;  // a curve of n segments has n + 1 normals
        text += list_text("normal N", part(shape.normals, first, first + (end - begin - 1) / 3 + 1), append_vector);
    }
    for (const auto& [name, width] : {std::pair{"float width0", shape.curve_widths[number].x},
                                      std::pair{"float width1", shape.curve_widths[number].y}})
        text += list_text(name, std::vector{width}, [](std::string& out, float value) { append_number(out, value); });
    return text + alpha_text(shape);
}

std::string shape_text(const SceneShape& shape, bool reverse_orientation) {
    const std::string extent = number_parameter("zmin", shape.z_min) + number_parameter("zmax", shape.z_max);
    std::string round = number_parameter("radius", shape.radius);
    if (shape.phi_max != 360) round += number_parameter("phimax", shape.phi_max);
    switch (shape.kind) {
        case ShapeKind::triangle_mesh:
            return "\"trianglemesh\"" + mesh_text(shape, reverse_orientation) + alpha_text(shape);
        case ShapeKind::bilinear_mesh:
            return "\"bilinearmesh\"" + mesh_text(shape, reverse_orientation) + alpha_text(shape);
        case ShapeKind::disk:
            return "\"disk\"" + round + number_parameter("height", shape.height) +
                   number_parameter("innerradius", shape.inner_radius) + alpha_text(shape);
        case ShapeKind::sphere:
            return "\"sphere\"" + round + extent + alpha_text(shape);
        case ShapeKind::curves:
            return curve_text(shape, 0);
        case ShapeKind::cylinder:
            break;
    }
    return "\"cylinder\"" + round + extent + alpha_text(shape);
}

std::string ply_content(const SceneShape& shape, bool reverse_orientation) {
    const bool patches = shape.kind == ShapeKind::bilinear_mesh;
    const std::size_t group = patches ? 4 : 3;
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(shape.positions.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
    if (!shape.normals.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (!shape.uvs.empty()) text += "property float u\nproperty float v\n";
    text += "element face " + std::to_string(shape.indices.size() / group) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
    const auto add = [&](const StoredVec3& v) {
        for (const float x : {v.x, v.y, v.z}) append_bytes(text, x);
    };
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
        add(shape.positions[i]);
        if (!shape.normals.empty()) add(as_written(shape.normals[i], reverse_orientation));
        if (shape.uvs.empty()) continue;
        append_bytes(text, shape.uvs[i].x);
        append_bytes(text, shape.uvs[i].y);
    }
    for (std::size_t i = 0; i + group <= shape.indices.size(); i += group) {
        const std::uint32_t* k = shape.indices.data() + i;
        append_bytes(text, static_cast<std::uint8_t>(group));
        append_bytes(text, k[0]);
        append_bytes(text, k[1]);
        if (patches) append_bytes(text, k[3]);  // around the face; a patch stores its corners row by row
        append_bytes(text, k[2]);
    }
    return text;
}

}  // namespace raylex::transport
