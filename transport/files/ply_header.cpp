#include "transport/files/ply_header.h"

#include <charconv>

#include "display/services/parameters.h"
#include "lpe/input/budgets.h"
#include "transport/files/tokenizer.h"

namespace raylex::transport::ply {

namespace {

struct ScalarRow {
    const char* name;
    Scalar type;
};
constexpr ScalarRow scalar_names[] = {
    {"char", Scalar::int8},     {"int8", Scalar::int8},       {"uchar", Scalar::uint8},    {"uint8", Scalar::uint8},
    {"short", Scalar::int16},   {"int16", Scalar::int16},     {"ushort", Scalar::uint16},  {"uint16", Scalar::uint16},
    {"int", Scalar::int32},     {"int32", Scalar::int32},     {"uint", Scalar::uint32},    {"uint32", Scalar::uint32},
    {"float", Scalar::float32}, {"float32", Scalar::float32}, {"double", Scalar::float64}, {"float64", Scalar::float64},
};

bool find_scalar(std::string_view name, Scalar& type) {
    for (const ScalarRow& row : scalar_names)
        if (name == row.name) return type = row.type, true;
    return false;
}

std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t i = 0; i < line.size();) {
        if (line[i] == ' ' || line[i] == '\t') {
            ++i;
            continue;
        }
        std::size_t stop = i;
        while (stop < line.size() && line[stop] != ' ' && line[stop] != '\t') ++stop;
        words.push_back(line.substr(i, stop - i));
        i = stop;
    }
    return words;
}

class HeaderParser {
  public:
    HeaderParser(std::string_view content, const std::string& path) : content_(content), path_(path) {}

    Result<Header> parse() {
        if (!next_line() || line_ != "ply") return failure("not a PLY file; expected the first line 'ply'");
        bool has_format = false;
        while (next_line()) {
            words_ = split(line_);
            if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
            if (words_[0] == "end_header") {
                if (!has_format) return failure("PLY header has no 'format' line");
                header_.data_begin = at_;
                return std::move(header_);
            }
            Status status = success();
            if (words_[0] == "format") {
                status = parse_format();
                has_format = true;
            } else if (words_[0] == "element") {
                status = parse_element();
            } else if (words_[0] == "property") {
                status = parse_property();
            } else {
                status = failure("found '" + shown(words_[0]) +
                                 "' in the PLY header; expected format, element, property, comment or end_header");
            }
            if (!status) return status.error();
        }
        return failure("PLY header is truncated; expected 'end_header'");
    }

  private:
    /// Reads a line. Lines end in "\n", "\r\n" or, in the header of old Macintosh files, "\r".
    bool next_line() {
        if (at_ >= content_.size()) return false;
        const std::size_t stop = content_.find_first_of("\r\n", at_);
        ++header_.lines;
        if (stop == std::string_view::npos) {
            line_ = content_.substr(at_);
            at_ = content_.size();
            return true;
        }
        line_ = content_.substr(at_, stop - at_);
        at_ = stop + 1;
        if (content_[stop] == '\r' && at_ < content_.size() && content_[at_] == '\n') ++at_;
        return true;
    }

    Status parse_format() {
        if (words_.size() != 3 || words_[2] != "1.0")
            return failure("expected 'format <ascii|binary_little_endian|binary_big_endian> 1.0'");
        if (words_[1] == "ascii") header_.format = Format::ascii;
        else if (words_[1] == "binary_little_endian") header_.format = Format::little_endian;
        else if (words_[1] == "binary_big_endian") header_.format = Format::big_endian;
        else
            return failure("unknown PLY format '" + shown(words_[1]) +
                           "'; expected ascii, binary_little_endian or binary_big_endian");
        return success();
    }

    Status parse_element() {
        std::uint64_t count = 0;
        const bool shaped = words_.size() == 3;
        const char* end = shaped ? words_[2].data() + words_[2].size() : nullptr;
        const auto [stop, status] = shaped ? std::from_chars(words_[2].data(), end, count) : std::from_chars_result{};
        if (!shaped || stop != end || status == std::errc::invalid_argument)
            return failure("expected 'element <name> <count>' with a count of at least 0");
        if (status == std::errc::result_out_of_range || count > budget(Budget::mesh_rows)) {
            Error error = over_budget(Budget::mesh_rows, "element count " + shown(words_[2]) + " is out of range",
                                      path_, header_.lines);
            error.excerpt = excerpt_of(line_, 1);
            return error;
        }
        header_.elements.push_back({std::string(words_[1]), count, {}});
        return success();
    }

    Status parse_property() {
        if (header_.elements.empty()) return failure("'property' before any 'element'");
        Property property;
        const bool list = words_.size() == 5 && words_[1] == "list";
        if (!list && words_.size() != 3)
            return failure("expected 'property <type> <name>' or 'property list <count type> <type> <name>'");
        property.is_list = list;
        property.name = words_.back();
        if (list && !find_scalar(words_[2], property.count_type)) return unknown_type(words_[2]);
        if (list && (property.count_type == Scalar::float32 || property.count_type == Scalar::float64))
            return failure("list count of type '" + shown(words_[2]) + "'; expected an integer type");
        if (!find_scalar(words_[list ? 3 : 1], property.type)) return unknown_type(words_[list ? 3 : 1]);
        header_.elements.back().properties.push_back(std::move(property));
        return success();
    }

    Error unknown_type(std::string_view name) const {
        return failure("unknown PLY type '" + shown(name) +
                       "'; expected char, uchar, short, ushort, int, uint, float or double");
    }

    static std::string shown(std::string_view word) { return std::string(word.substr(0, 40)); }

    Error failure(std::string message) const {
        Error error = error_at({path_, header_.lines, 0}, std::move(message));
        error.excerpt = excerpt_of(line_, 1);
        return error;
    }

    std::string_view content_, line_;
    const std::string& path_;
    std::vector<std::string_view> words_;
    std::size_t at_ = 0;
    Header header_;
};

}  // namespace

std::size_t size_of(Scalar type) {
    switch (type) {
        case Scalar::int8:
        case Scalar::uint8:
            return 1;
        case Scalar::int16:
        case Scalar::uint16:
            return 2;
        case Scalar::int32:
        case Scalar::uint32:
        case Scalar::float32:
            return 4;
        case Scalar::float64:
            break;
    }
    return 8;
}

std::size_t Element::smallest_row() const {
    std::size_t size = 0;
    for (const Property& property : properties) size += size_of(property.is_list ? property.count_type : property.type);
    return size;
}

const Element* Header::find(std::string_view name) const {
    for (const Element& element : elements)
        if (element.name == name) return &element;
    return nullptr;
}

Result<Header> parse_header(std::string_view content, const std::string& path) {
    return HeaderParser(content, path).parse();
}

}  // namespace raylex::transport::ply
