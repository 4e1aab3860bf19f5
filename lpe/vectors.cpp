#include "lpe/vectors.h"

#include <optional>
#include <utility>

#include "lpe/input/read_input.h"
#include "lpe/match.h"
#include "lpe/program.h"

namespace raylex::lpe {

namespace {

Error row_error(const std::string& origin, int line, int column, std::string_view row, std::string message,
                std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.file = origin;
    error.line = line;
    error.column = column;
    error.excerpt = std::string(row);
    error.hint = std::move(hint);
    return error;
}

/// Rows of one expression are usually adjacent, so the last program is kept.
class VectorRunner {
  public:
    VectorRunner(std::string origin, Dialect dialect) : origin_(std::move(origin)), dialect_(dialect) {}

    /// Runs a row. Returns an error if the row itself is malformed.
    std::optional<Error> run(std::string_view row, int line, VectorReport& report) {
        const std::size_t first = row.find('\t');
        const std::size_t second = first == std::string_view::npos ? first : row.find('\t', first + 1);
        if (second == std::string_view::npos) {
            return row_error(origin_, line, static_cast<int>(row.size()) + 1, row,
                             "the row ends early; expected EXPRESSION<TAB>EVENTS<TAB>EXPECTED");
        }
        VectorRow result;
        result.line = line;
        result.expression = std::string(row.substr(0, first));
        result.events = std::string(row.substr(first + 1, second - first - 1));
        result.expected = std::string(row.substr(second + 1));
        if (result.expected != "0" && result.expected != "1" && result.expected != "ERR" &&
            result.expected != "NOCRASH") {
            return row_error(origin_, line, static_cast<int>(second) + 2, row,
                             "found '" + result.expected + "'; expected 1, 0, ERR or NOCRASH");
        }
        const Result<std::vector<Event>> events = parse_events(result.events);
        if (!events) {
            return row_error(origin_, line, static_cast<int>(first) + 1 + events.error().column, row,
                             events.error().message, events.error().hint);
        }
        find(result, *events);
        if (result.expected == "NOCRASH" || result.expected == result.found) {
            ++report.agree;
        } else {
            report.disagree.push_back(std::move(result));
        }
        return std::nullopt;
    }

  private:
    void find(VectorRow& result, const std::vector<Event>& events) {
        if (!compiled_ || source_.expression != result.expression) {
            source_.expression = result.expression;
            source_.dialect = dialect_;
            compiled_.emplace(Program::compile({&source_, 1}, {.any_path_string = true}));
        }
        if (!*compiled_) {
            result.found = "ERR";
            result.message = compiled_->error().to_string();
            return;
        }
        const Program& program = **compiled_;
        State state = program.starts().front();
        for (const Event& event : events) { state = program.next(state, program.classify(event)); }
        result.found.assign(1, program.accepts_any(state) ? '1' : '0');
    }

    std::string origin_;
    Dialect dialect_;
    ChannelSource source_;
    std::optional<Result<Program>> compiled_;
};

}  // namespace

Result<VectorReport> run_vectors_text(std::string_view text, const std::string& origin, Dialect dialect) {
    VectorReport report;
    VectorRunner runner(origin, dialect);
    int line = 0;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        std::string_view row = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        ++line;
        if (!row.empty() && row.back() == '\r') { row.remove_suffix(1); }
        if (row.empty() || row.front() == '#') { continue; }
        if (std::optional<Error> error = runner.run(row, line, report)) { return std::move(*error); }
    }
    return report;
}

Result<VectorReport> run_vectors(const std::string& path, Dialect dialect) {
    const auto text = read_input(path, NamedBy::command_line, "a file of rows EXPRESSION, EVENTS, EXPECTED");
    if (!text) { return text.error(); }
    return run_vectors_text(*text, path, dialect);
}

}  // namespace raylex::lpe
