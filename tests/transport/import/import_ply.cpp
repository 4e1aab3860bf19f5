// PLY files in every encoding, written here, and invalid in every way.
#include <catch2/catch.hpp>

#include <bit>
#include <cstring>
#include <functional>

#include "tests/transport/import_support.h"
#include "transport/files/ply.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

enum class Order { ascii, little, big };

const char* format_name(Order order) {
    return order == Order::ascii ? "ascii" : order == Order::little ? "binary_little_endian" : "binary_big_endian";
}

/// Appends numbers as text or bytes.
class PlyWriter {
  public:
    explicit PlyWriter(Order order) : order_(order) {}

    template <class T>
    PlyWriter& put(T value) {
        if (order_ == Order::ascii) {
            if (!data.empty() && data.back() != '\n') data += ' ';
            data += number_text(value);
            return *this;
        }
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        const bool swap = (order_ == Order::big) == (std::endian::native == std::endian::little);
        if (swap) std::reverse(std::begin(bytes), std::end(bytes));
        data.append(bytes, sizeof(T));
        return *this;
    }
    void end_row() {
        if (order_ == Order::ascii) data += "\n";
    }

    std::string data;

  private:
    template <class T>
    static std::string number_text(T value) {
        if constexpr (std::is_integral_v<T>) return std::to_string(value);
        else return std::to_string(static_cast<double>(value));
    }
    Order order_;
};

/// A triangle, a quadrilateral and a pentagon over five vertices, with normals, texture coordinates and parts to skip.
std::string full_file(Order order, const std::string& u = "u", const std::string& v = "v",
                      const std::string& list = "vertex_indices") {
    std::string text = std::string("ply\nformat ") + format_name(order) +
                       " 1.0\ncomment made by a test\nobj_info nothing\nelement extra 2\nproperty list uchar short "
                       "skipped\nproperty double d\n"
                       "element vertex 5\nproperty uchar red\nproperty float x\nproperty double y\nproperty float z\n"
                       "property float nx\nproperty float ny\nproperty float nz\nproperty float " +
                       u + "\nproperty float " + v +
                       "\nelement face 3\nproperty uchar flags\nproperty list uchar int " + list +
                       "\nelement edge 1\nproperty int a\nend_header\n";
    PlyWriter w(order);
    for (int row = 0; row < 2; ++row) {
        w.put<std::uint8_t>(static_cast<std::uint8_t>(row));
        for (int i = 0; i < row; ++i) w.put<std::int16_t>(-3);
        w.put<double>(0.5);
        w.end_row();
    }
    const double xyz[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0.5, 0}};
    for (const auto& p : xyz) {
        w.put<std::uint8_t>(200)
            .put<float>(static_cast<float>(p[0]))
            .put<double>(p[1])
            .put<float>(static_cast<float>(p[2]));
        w.put<float>(0)
            .put<float>(0)
            .put<float>(1)
            .put<float>(static_cast<float>(p[0]) / 4)
            .put<float>(static_cast<float>(p[1]) / 4);
        w.end_row();
    }
    const std::vector<std::vector<int>> faces{{0, 1, 2}, {0, 1, 2, 3}, {0, 1, 2, 3, 4}};
    for (const auto& face : faces) {
        w.put<std::uint8_t>(7).put<std::uint8_t>(static_cast<std::uint8_t>(face.size()));
        for (const int index : face) w.put<std::int32_t>(index);
        w.end_row();
    }
    w.put<std::int32_t>(0);
    w.end_row();
    return text + w.data;
}

/// One triangle with these vertex coordinates and indices, in the given byte order.
std::string small_file(Order order, float bad = 1, std::int32_t index = 2) {
    PlyWriter w(order);
    for (const float c : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, bad, 0.0f}) {
        w.put<float>(c);
        if (w.data.size() % 3 == 0) w.end_row();
    }
    w.end_row();
    w.put<std::uint8_t>(3).put<std::int32_t>(0).put<std::int32_t>(1).put<std::int32_t>(index);
    return std::string("ply\nformat ") + format_name(order) +
           " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty "
           "list uchar int vertex_index\nend_header\n" +
           w.data;
}

raylex::Error ply_error(const std::string& content) {
    const auto mesh = parse_ply(content, "m.ply");
    if (mesh) FAIL("accepted");
    INFO(mesh.error().to_string());
    CHECK(mesh.error().file == "m.ply");
    return mesh.error();
}

std::string header(const std::string& lines) {
    return "ply\n" + lines + "end_header\n";
}
const std::string xyz_lines = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
const std::string face_lines = "element face 1\nproperty list uchar int vertex_indices\n";

}  // namespace

TEST_CASE("ASCII, little- and big-endian files give the same mesh; quads stay patches and polygons are omitted",
          "[import][ply]") {
    for (const Order order : {Order::ascii, Order::little, Order::big}) {
        INFO(format_name(order));
        const auto mesh = parse_ply(full_file(order), "m.ply");
        if (!mesh) FAIL(mesh.error().to_string());
        REQUIRE(mesh->positions.size() == 5);
        CHECK(mesh->positions[4] == Vec3{-1, 0.5f, 0});
        CHECK(mesh->normals == std::vector<Vec3>(5, Vec3{0, 0, 1}));
        CHECK(mesh->uvs[2] == Vec2{0.25f, 0.25f});
        CHECK(mesh->triangles == std::vector<std::uint32_t>{0, 1, 2});
        CHECK(mesh->quads == std::vector<std::uint32_t>{0, 1, 3, 2});
        CHECK(mesh->odd_faces == 1);
    }
}

TEST_CASE("all common names of texture coordinates and index lists are supported", "[import][ply]") {
    for (const auto& [u, v] : {std::pair{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}})
        CHECK(parse_ply(full_file(Order::little, u, v), "m.ply")->uvs.size() == 5);
    CHECK(parse_ply(full_file(Order::little, "p", "q"), "m.ply")->uvs.empty());
    CHECK(parse_ply(full_file(Order::big, "u", "v", "vertex_index"), "m.ply")->quads.size() == 4);
}

TEST_CASE("carriage returns and blank lines do not matter", "[import][ply]") {
    std::string text = full_file(Order::ascii), crlf;
    for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    CHECK(parse_ply(crlf, "m.ply")->triangles.size() == 3);
    text.insert(text.find("end_header\n") + 11, "\n  \n");
    CHECK(parse_ply(text, "m.ply")->triangles.size() == 3);
}

TEST_CASE("faces with neither three nor four vertices are omitted and counted, whatever their indices",
          "[import][ply]") {
    std::string text =
        header("format ascii 1.0\n" + xyz_lines + "element face 4\nproperty list uchar int vertex_indices\n") +
        "0 0 0\n0\n1 0\n2 0 0\n5 0 0 0 -1 9\n";
    const auto mesh = parse_ply(text, "m.ply");
    if (!mesh) FAIL(mesh.error().to_string());
    CHECK(mesh->odd_faces == 4);
    CHECK(mesh->triangles.empty());
    CHECK(mesh->quads.empty());
}

TEST_CASE("a file that is truncated anywhere is an error", "[law7][import][ply]") {
    for (const Order order : {Order::ascii, Order::little, Order::big}) {
        const std::string whole = full_file(order);
        // The last element is skipped but must be complete. In ASCII a truncated number is another number, so cuts are
        // at blanks.
        for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
            if (order == Order::ascii && size > whole.find("end_header") && whole[size] != ' ' && whole[size] != '\n')
                continue;
            if (order == Order::ascii && size + 3 > whole.size()) continue;
            const auto mesh = parse_ply(whole.substr(0, size), "m.ply");
            INFO(format_name(order) << " cut to " << size << " of " << whole.size());
            REQUIRE_FALSE(mesh);
            REQUIRE(mesh.error().file == "m.ply");
        }
    }
    const raylex::Error binary = ply_error(small_file(Order::little).substr(0, small_file(Order::little).size() - 1));
    CHECK(contains(binary.message, "'vertex_index' of face 0 of 1"));
    CHECK(contains(binary.message, "3 bytes left"));
    CHECK(contains(binary.message, "at byte "));
}

TEST_CASE("an index out of range names the face, the index and the position", "[law7][import][ply]") {
    for (const std::int32_t index : {3, -1}) {
        const raylex::Error ascii = ply_error(small_file(Order::ascii, 1, index));
        CHECK(contains(ascii.message,
                       "face 0 refers to vertex " + std::to_string(index) + "; expected an index from 0 to 2"));
        CHECK(ascii.line > 9);
        const raylex::Error big = ply_error(small_file(Order::big, 1, index));
        CHECK(contains(big.message, "face 0 refers to vertex " + std::to_string(index)));
        CHECK(contains(big.message, "at byte " + std::to_string(small_file(Order::big).size())));
    }
}

TEST_CASE("a vertex that is not finite names the vertex and the position", "[law7][import][ply]") {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        CHECK(contains(ply_error(small_file(Order::little, bad)).message,
                       "vertex 2 has a 'y' that is not a finite float"));
        const raylex::Error ascii = ply_error(header("format ascii 1.0\n" + xyz_lines + face_lines) + "0 " +
                                              (std::isnan(bad) ? "nan" : "inf") + " 0\n0\n");
        CHECK(ascii.line == 10);
        CHECK(contains(ascii.message, "vertex 0 has a 'y'"));
    }
    CHECK(contains(ply_error(header("format ascii 1.0\n" + xyz_lines + face_lines) + "0 1e99 0\n0\n").message,
                   "not a finite float"));
}

TEST_CASE("a header that does not parse names its line", "[law7][import][ply]") {
    struct Case {
        std::string text;
        int line;
        const char* message;
    };
    const Case cases[] = {
        {"", 0, "not a PLY file"},
        {"obj\n", 1, "not a PLY file"},
        {"ply\nformat ascii 1.0\n", 2, "truncated; expected 'end_header'"},
        {header("element vertex 1\n"), 3, "no 'format' line"},
        {header("format ascii 2.0\n"), 2, "expected 'format"},
        {header("format text 1.0\n"), 2, "unknown PLY format 'text'"},
        {header("format ascii 1.0\nelement vertex\n"), 3, "expected 'element <name> <count>'"},
        {header("format ascii 1.0\nelement vertex -1\n"), 3, "count of at least 0"},
        {header("format ascii 1.0\nelement vertex 99999999999\n"), 3, "the budget mesh_rows is 536870912"},
        {header("format ascii 1.0\nproperty float x\n"), 3, "before any 'element'"},
        {header("format ascii 1.0\nelement vertex 1\nproperty half x\n"), 4, "unknown PLY type 'half'"},
        {header("format ascii 1.0\nelement face 1\nproperty list float int vertex_indices\n"), 4,
         "expected an integer type"},
        {header("format ascii 1.0\nelement face 1\nproperty list uchar int\n"), 4, "expected 'property"},
        {header("format ascii 1.0\nvertex 3\n"), 3, "found 'vertex' in the PLY header"},
        {header("format ascii 1.0\n" + face_lines), 0, "no 'vertex' element"},
        {header("format ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n" + face_lines), 0, "no 'z'"},
        {header("format ascii 1.0\n" + xyz_lines), 0, "no 'face' element"},
        {header("format ascii 1.0\n" + xyz_lines + "element face 1\nproperty int a\n"), 0, "no list 'vertex_indices'"},
    };
    for (const Case& c : cases) {
        INFO(c.text);
        const raylex::Error error = ply_error(c.text);
        CHECK(error.line == c.line);
        CHECK(contains(error.message, c.message));
    }
}

TEST_CASE("a count that does not fit into the file is refused before memory is allocated", "[law7][import][ply]") {
    for (const char* format : {"ascii", "binary_little_endian"}) {
        const std::string start = std::string("format ") + format + " 1.0\n";
        CHECK(contains(
            ply_error(header(start +
                             "element vertex 500000000\nproperty float x\nproperty float y\nproperty float z\n" +
                             face_lines) +
                      "0 0 0")
                .message,
            "claims 500000000 rows"));
    }
    // A list must not extend past the end either.
    PlyWriter w(Order::little);
    w.put<float>(0).put<float>(0).put<float>(0).put<std::uint32_t>(4000000000U).put<std::int32_t>(0);
    CHECK(contains(ply_error(header("format binary_little_endian 1.0\n" + xyz_lines +
                                    "element face 1\nproperty list uint int vertex_indices\n") +
                             w.data)
                       .message,
                   "ends early"));
}

TEST_CASE("a plymesh becomes shapes that store their file name; triangles and quads are separate shapes",
          "[import][ply]") {
    const Folder folder;
    folder.write("meshes/all.ply", full_file(Order::big));
    const auto scene = import_pbrt(folder.write(
        "s.pbrt",
        "WorldBegin Scale 2 2 -2 Shape \"plymesh\" \"string filename\" \"meshes/all.ply\" \"float alpha\" 0.5"));
    if (!scene) FAIL(scene.error().to_string());
    REQUIRE(scene->shapes.size() == 2);
    CHECK(scene->shapes[0].kind == ShapeKind::bilinear_mesh);
    CHECK(scene->shapes[1].kind == ShapeKind::triangle_mesh);
    for (const SceneShape& shape : scene->shapes) {
        CHECK(shape.source_file == "all.ply");
        CHECK(placed(shape).positions[4] == Vec3{-2, 1, 0});
        CHECK(placed(shape).normals[0] == Vec3{0, 0, -0.5f});
        CHECK(shape.flip_normal);
        CHECK(shape.alpha == 0.5f);
    }
    REQUIRE(scene->warnings.size() == 1);
    CHECK(contains(scene->warnings[0].message, "1 of the faces of "));
    CHECK(contains(scene->warnings[0].message, "all.ply"));
    CHECK(contains(scene->warnings[0].message, "have neither 3 nor 4 vertices and are left out, as in pbrt-v4"));
    CHECK(scene->warnings[0].line == 1);
    const auto broken =
        import_pbrt(folder.write("b.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"s.pbrt\""));
    REQUIRE_FALSE(broken);
    CHECK(broken.error().file == folder.path("s.pbrt"));
    CHECK(contains(broken.error().hint, "b.pbrt:2"));
}
