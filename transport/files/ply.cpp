#include "transport/files/ply.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "display/services/parameters.h"
#include "transport/files/input_file.h"
#include "transport/files/ply_header.h"

namespace raylex::transport {

namespace {

using ply::Element;
using ply::Format;
using ply::Header;
using ply::Property;
using ply::Scalar;

/// Reads scalars from ASCII text, and keeps the line number for messages.
class AsciiSource {
  public:
    AsciiSource(std::string_view content, const Header& header)
        : content_(content), at_(header.data_begin), line_(header.lines + 1) {}

    bool read(Scalar, double& value) {
        skip_blanks();
        const char* begin = content_.data() + at_;
        const char* const end = content_.data() + content_.size();
        if (begin != end && *begin == '+') ++begin;
        const auto [stop, status] = std::from_chars(begin, end, value);
        if (status == std::errc::result_out_of_range) value = HUGE_VAL;
        if (stop == begin) return false;
        const char* after = stop;
        if (stop != end && *stop == '#') {  // "1.#QNAN", "-1.#IND", "1.#INF": spellings of the C library of Windows
            value = std::numeric_limits<double>::quiet_NaN();
            while (after != end && !is_blank(*after)) ++after;
        }
        if (after != end && !is_blank(*after)) return false;
        at_ = static_cast<std::size_t>(after - content_.data());
        return true;
    }
    /// Whether `count` rows of at least `numbers` numbers can still follow: each number needs a digit and a blank.
    [[nodiscard]] bool can_hold(std::uint64_t count, std::size_t numbers, std::size_t) const {
        return count * numbers <= (content_.size() - at_) / 2 + 1;
    }
    [[nodiscard]] SourceLocation location(const std::string& path) const { return {path, line_, 0}; }
    [[nodiscard]] std::string place() const { return ""; }
    [[nodiscard]] std::string found() {
        skip_blanks();
        if (at_ == content_.size()) return "the end of the file";
        std::size_t stop = at_;
        while (stop < content_.size() && !is_blank(content_[stop]) && stop - at_ < 40) ++stop;
        return std::string("'").append(content_.substr(at_, stop - at_)).append("'");
    }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
    void skip_blanks() {
        for (; at_ < content_.size() && is_blank(content_[at_]); ++at_)
            if (content_[at_] == '\n') ++line_;
    }

    std::string_view content_;
    std::size_t at_;
    int line_;
};

/// Reads scalars from binary data; Swap: the file's byte order is not the machine's.
template <bool Swap>
class BinarySource {
  public:
    BinarySource(std::string_view content, const Header& header) : content_(content), at_(header.data_begin) {}

    bool read(Scalar type, double& value) {
        const std::size_t size = ply::size_of(type);
        if (content_.size() - at_ < size) return false;
        const char* from = content_.data() + at_;
        at_ += size;
        switch (type) {
            case Scalar::int8:
                value = load<std::int8_t>(from);
                break;
            case Scalar::uint8:
                value = load<std::uint8_t>(from);
                break;
            case Scalar::int16:
                value = load<std::int16_t>(from);
                break;
            case Scalar::uint16:
                value = load<std::uint16_t>(from);
                break;
            case Scalar::int32:
                value = load<std::int32_t>(from);
                break;
            case Scalar::uint32:
                value = load<std::uint32_t>(from);
                break;
            case Scalar::float32:
                value = static_cast<double>(load<float>(from));
                break;
            case Scalar::float64:
                value = load<double>(from);
                break;
        }
        return true;
    }
    [[nodiscard]] bool can_hold(std::uint64_t count, std::size_t, std::size_t bytes) const {
        return count * bytes <= content_.size() - at_;
    }
    [[nodiscard]] SourceLocation location(const std::string& path) const { return {path, 0, 0}; }
    [[nodiscard]] std::string place() const { return std::string(" at byte ").append(std::to_string(at_)); }
    [[nodiscard]] std::string found() const { return std::to_string(content_.size() - at_) + " bytes left"; }

  private:
    template <class T>
    static T load(const char* from) {
        char bytes[sizeof(T)];
        for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = from[Swap ? sizeof(T) - 1 - i : i];
        T value;
        std::memcpy(&value, bytes, sizeof(T));
        return value;
    }

    std::string_view content_;
    std::size_t at_;
};

/// The index of a vertex property among x y z nx ny nz u v; -1: skipped.
int vertex_slot(std::string_view name) {
    constexpr std::string_view names[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int i = 0; i < 6; ++i)
        if (name == names[i]) return i;
    if (name == "u" || name == "s" || name == "texture_u" || name == "texture_s") return 6;
    if (name == "v" || name == "t" || name == "texture_v" || name == "texture_t") return 7;
    return -1;
}

bool is_index_list(const Property& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class Source>
class MeshReader {
  public:
    MeshReader(Source source, const Header& header, const std::string& path)
        : source_(source), header_(header), path_(path) {}

    Result<PlyMesh> read() {
        const Element* vertices = header_.find("vertex");
        vertex_count_ = vertices->count;
        for (const Element& element : header_.elements) {
            // Rejects a count that does not fit into the file before memory is allocated.
            if (!source_.can_hold(element.count, element.properties.size(), element.smallest_row()))
                return failure("PLY file is truncated: element '" + element.name + "' claims " +
                               std::to_string(element.count) + " rows, found " + source_.found());
            Status status = &element == vertices ? read_vertices(element) : read_rows(element);
            if (!status) return status.error();
        }
        return std::move(mesh_);
    }

  private:
    Status read_vertices(const Element& element) {
        std::vector<int> slots;
        bool seen[8] = {};
        for (const Property& property : element.properties) {
            slots.push_back(property.is_list ? -1 : vertex_slot(property.name));
            if (slots.back() >= 0) seen[slots.back()] = true;
        }
        const bool has_normals = seen[3] && seen[4] && seen[5], has_uvs = seen[6] && seen[7];
        mesh_.positions.resize(element.count);
        if (has_normals) mesh_.normals.resize(element.count);
        if (has_uvs) mesh_.uvs.resize(element.count);
        for (std::size_t row = 0; row < element.count; ++row) {
            double values[8] = {};
            for (std::size_t p = 0; p < slots.size(); ++p) {
                double value = 0;
                if (Status status = read_property(element, element.properties[p], row, value); !status) return status;
                if (slots[p] < 0) continue;
                if (!std::isfinite(static_cast<float>(value)) && slots[p] < 3)
                    return failure("vertex " + std::to_string(row) + " has a '" + element.properties[p].name +
                                   "' that is not a finite float; expected a number");
                values[slots[p]] = value;
            }
            const auto f = [&values](int i) { return static_cast<float>(values[i]); };
            mesh_.positions[row] = {f(0), f(1), f(2)};
            if (has_normals) mesh_.normals[row] = {f(3), f(4), f(5)};
            if (!has_uvs) continue;
            mesh_.uvs[row] = {f(6), f(7)};
            if (std::isfinite(mesh_.uvs[row].x) && std::isfinite(mesh_.uvs[row].y)) continue;
            mesh_.uvs[row] = {};
            ++mesh_.broken_uvs;
        }
        return success();
    }

    Status read_rows(const Element& element) {
        const bool faces = element.name == "face";
        // An element without properties takes no bytes, so its count alone must not cause work.
        if (element.properties.empty()) return success();
        if (faces) mesh_.triangles.reserve(static_cast<std::size_t>(element.count) * 3);
        for (std::size_t row = 0; row < element.count; ++row)
            for (const Property& property : element.properties) {
                double value = 0;
                Status status = faces && is_index_list(property) ? read_face(element, property, row)
                                                                 : read_property(element, property, row, value);
                if (!status) return status;
            }
        return success();
    }

    /// Reads one scalar, or a list whose values are skipped.
    Status read_property(const Element& element, const Property& property, std::size_t row, double& value) {
        if (!source_.read(property.is_list ? property.count_type : property.type, value))
            return truncated(element, property, row);
        if (!property.is_list) return success();
        if (!(value >= 0)) return failure("negative list count in " + element.name + " " + std::to_string(row));
        for (double left = value; left >= 1; --left) {
            double skipped = 0;
            if (!source_.read(property.type, skipped)) return truncated(element, property, row);
        }
        return success();
    }

    Status read_face(const Element& element, const Property& property, std::size_t row) {
        double count = 0;
        if (!source_.read(property.count_type, count)) return truncated(element, property, row);
        if (!(count >= 0) || count != std::floor(count))
            return failure("face " + std::to_string(row) +
                           " has a vertex count that is not a whole number of at least 0");
        const bool kept = count == 3 || count == 4;
        if (!kept) ++mesh_.odd_faces;
        std::uint32_t corners[4] = {};
        for (std::size_t i = 0; static_cast<double>(i) < count; ++i) {
            double index = 0;
            if (!source_.read(property.type, index)) return truncated(element, property, row);
            if (!kept) continue;
            if (!(index >= 0) || !(index < static_cast<double>(vertex_count_)) || index != std::floor(index))
                return bad_index(row, index);
            corners[i] = static_cast<std::uint32_t>(index);
        }
        if (count == 3) mesh_.triangles.insert(mesh_.triangles.end(), {corners[0], corners[1], corners[2]});
        // The file lists corners around the face; a patch lists its rows.
        if (count == 4) mesh_.quads.insert(mesh_.quads.end(), {corners[0], corners[1], corners[3], corners[2]});
        return success();
    }

    Error bad_index(std::size_t row, double index) const {
        std::string shown = std::to_string(index);
        if (std::isfinite(index) && index == std::floor(index)) shown.resize(shown.find('.'));
        return failure("face " + std::to_string(row) + " refers to vertex " + shown + "; expected an index from 0 to " +
                       std::to_string(static_cast<std::int64_t>(vertex_count_) - 1));
    }

    Error truncated(const Element& element, const Property& property, std::size_t row) {
        return failure("PLY data ends early or is not a number: found " + source_.found() + "; expected '" +
                       property.name + "' of " + element.name + " " + std::to_string(row) + " of " +
                       std::to_string(element.count));
    }

    Error failure(const std::string& message) const {
        return error_at(source_.location(path_), message + source_.place());
    }

    Source source_;
    const Header& header_;
    const std::string& path_;
    std::uint64_t vertex_count_ = 0;
    PlyMesh mesh_;
};

Status check_elements(const Header& header, const std::string& path) {
    const auto fail = [&](std::string message) { return error_at({path, 0, 0}, std::move(message)); };
    const Element* vertices = header.find("vertex");
    if (vertices == nullptr) return fail("PLY file has no 'vertex' element");
    for (const char* coordinate : {"x", "y", "z"}) {
        bool found = false;
        for (const Property& property : vertices->properties) found |= property.name == coordinate && !property.is_list;
        if (!found) return fail(std::string("PLY vertices have no '") + coordinate + "'; expected x, y and z");
    }
    const Element* faces = header.find("face");
    if (faces == nullptr) return fail("PLY file has no 'face' element; triangle strips are not supported");
    for (const Property& property : faces->properties)
        if (is_index_list(property)) return success();
    return fail("PLY faces have no list 'vertex_indices' or 'vertex_index'");
}

}  // namespace

Result<PlyMesh> parse_ply(const std::string& content, const std::string& path) {
    const Result<Header> header = ply::parse_header(content, path);
    if (!header) return header.error();
    if (Status status = check_elements(*header, path); !status) return status.error();
    if (header->format == Format::ascii) return MeshReader(AsciiSource(content, *header), *header, path).read();
    const bool native = (header->format == Format::little_endian) == (std::endian::native == std::endian::little);
    if (native) return MeshReader(BinarySource<false>(content, *header), *header, path).read();
    return MeshReader(BinarySource<true>(content, *header), *header, path).read();
}

Result<PlyMesh> read_ply(const std::string& path) {
    const Result<std::string> content = read_file(path, NamedBy::file, "a PLY mesh");
    if (!content) return content.error();
    return parse_ply(*content, path);
}

}  // namespace raylex::transport
