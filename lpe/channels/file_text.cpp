#include "lpe/channels/file_text.h"

#include <algorithm>
#include <utility>

#include "lpe/channels/channel_errors.h"
#include "lpe/failure.h"
#include "lpe/language/source_text.h"

namespace raylex::lpe {

void MappedText::append(char c, std::size_t position) {
    if (runs_.empty() || runs_.back().position + (text_.size() - runs_.back().offset) != position) {
        runs_.push_back({text_.size(), position});
    }
    text_ += c;
}

std::size_t MappedText::position(std::size_t offset) const {
    const auto after = std::upper_bound(runs_.begin(), runs_.end(), offset,
                                        [](std::size_t at, const Run& run) { return at < run.offset; });
    return after == runs_.begin() ? start_ : (after - 1)->position + (offset - (after - 1)->offset);
}

FileText::FileText(std::string_view text, const std::string& origin)
    : file_(std::make_shared<const TextFile>(TextFile{origin, std::string(text), true})), line_begins_{0} {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\n') { line_begins_.push_back(i + 1); }
    }
}

std::string_view FileText::take_line() {
    const std::size_t begin = position_;
    const std::size_t end = std::min(text().find('\n', begin), text().size());
    position_ = std::min(end + 1, text().size());
    std::string_view line = text().substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') { line.remove_suffix(1); }
    return line;
}

int FileText::line_of(std::size_t position) const {
    return static_cast<int>(std::upper_bound(line_begins_.begin(), line_begins_.end(), position) -
                            line_begins_.begin());
}

int FileText::column_of(std::size_t position) const {
    return static_cast<int>(position - line_begins_[static_cast<std::size_t>(line_of(position)) - 1]) + 1;
}

Error FileText::error_at(std::size_t position, std::string message, std::string hint) const {
    const TextPlace place = place_of(*file_, position);
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    error.file = file_->name;
    error.line = place.line;
    error.column = place.column;
    error.excerpt = place.line_text;
    return error;
}

void FileText::fail_at(std::size_t position, std::string message, std::string hint) const {
    throw Failure{error_at(position, std::move(message), std::move(hint))};
}

void FileText::note(std::size_t position, std::string message, std::string hint) {
    errors_.push_back(error_at(position, std::move(message), std::move(hint)));
}

void FileText::note_unless_known(std::size_t position, const std::string& what, std::string_view word,
                                 std::span<const std::string_view> known) {
    if (std::find(known.begin(), known.end(), word) != known.end()) { return; }
    std::string list;
    for (const std::string_view each : known) { list += (list.empty() ? "" : ", ") + std::string(each); }
    const std::string near = nearest(word, known.data(), known.size());
    note(position, "unknown " + what + " '" + std::string(word) + "'; expected one of: " + list,
         near.empty() ? "" : "did you mean '" + near + "'?");
}

ChannelFile FileText::return_or_throw(ChannelFile file) {
    if (errors_.empty()) { return file; }
    ChannelErrors wrong;
    wrong.error = errors_.front();
    wrong.errors = std::move(errors_);
    wrong.file = std::move(file);
    throw wrong;
}

std::string FileText::describe(std::size_t position) const {
    if (position >= text().size()) { return "the end of the file"; }
    ChannelSource around;
    around.expression = std::string(text().substr(position, 8));
    return SourceText(around).describe(0);
}

ChannelSource FileText::source(std::string name, const MappedText& text, std::size_t offset) const {
    ChannelSource source;
    source.name = std::move(name);
    source.expression = text.text().substr(offset);
    source.origin = file_->name;
    source.origin_line = line_of(text.position(offset));
    source.origin_column = column_of(text.position(offset));
    auto map = std::make_shared<SourceMap>();
    map->spans.push_back({0, file_, text.position(offset), {}});
    for (const MappedText::Run& run : text.runs_) {
        if (run.offset > offset) { map->spans.push_back({run.offset - offset, file_, run.position, {}}); }
    }
    source.map = std::move(map);
    return source;
}

std::size_t expression_offset(std::string_view source) {
    const std::size_t mark = source.find("lpe:");
    if (mark == std::string_view::npos) { return mark; }
    // The text before the mark must be empty or consist of the words of a type declaration ("varying color").
    const bool declared = std::all_of(source.begin(), source.begin() + static_cast<std::ptrdiff_t>(mark), [](char c) {
        return c == ' ' || c == '\t' || c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
               (c >= 'A' && c <= 'Z');
    });
    const bool separate = mark == 0 || source[mark - 1] == ' ' || source[mark - 1] == '\t';
    return declared && separate ? mark + 4 : std::string_view::npos;
}

std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        switch (c) {
            case '"':
                result += "\\\"";
                break;
            case '\\':
                result += "\\\\";
                break;
            case '\n':
                result += "\\n";
                break;
            case '\r':
                result += "\\r";
                break;
            case '\t':
                result += "\\t";
                break;
            default:
                result += c;
        }
    }
    return result + "\"";
}

std::string commented(const std::string& comment, const std::string& mark) {
    std::string result;
    for (std::size_t begin = 0; begin < comment.size();) {
        const std::size_t end = std::min(comment.find('\n', begin), comment.size());
        result += mark + (end > begin ? " " : "") + comment.substr(begin, end - begin) + "\n";
        begin = end + 1;
    }
    return result;
}

}  // namespace raylex::lpe
