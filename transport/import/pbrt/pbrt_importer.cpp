#include "transport/import/pbrt/pbrt_importer.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "transport/files/input_file.h"
#include "transport/import/pbrt/parser.h"
#include "transport/import/pbrt/scene_reader.h"

namespace raylex::transport {

namespace fs = std::filesystem;

namespace {

/// One open scene file.
struct Source {
    std::string path, identity;  // identity: equal for all spellings of the path
    std::shared_ptr<const std::string> text;
    Tokenizer tokenizer;
    bool imported = false;

    Source(std::string file, std::string id, std::shared_ptr<const std::string> content)
        : path(std::move(file)), identity(std::move(id)), text(std::move(content)), tokenizer(*text, path) {}
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;
};

std::string identity_of(const std::string& path) {
    std::error_code status;
    const fs::path canonical = fs::weakly_canonical(path, status);
    return status ? path : canonical.string();
}

class Importer {
  public:
    Importer(const std::string& path, std::string text, const ImportOptions& options)
        : reader_(path, options.missing, options.threads, options.progress), folder_(fs::path(path).parent_path()) {
        push(path, identity_of(path), std::make_shared<const std::string>(std::move(text)), false);
    }

    Result<SceneDescription> run() {
        SourceLocation end{sources_.front()->path, 1, 1};
        while (!sources_.empty()) {
            Source& source = *sources_.back();
            if (reading_stopped()) return reading_stopped_error(source.path);
            // File names are relative to the file in which a directive begins, and most begin in the file of the
            // previous one.
            if (std::exchange(moved_on_, false)) reader_.set_search(search());
            Result<std::optional<Directive>> directive = parse_directive(source.tokenizer);
            if (!directive) return directive.error();
            Status status = directive->has_value() ? read_on(**directive) : success();
            if (!status) return status.error();
            if (!directive->has_value()) {
                if (sources_.size() == 1) end = end_of(source);
                status = pop();
            } else if ((*directive)->id == DirectiveId::include || (*directive)->id == DirectiveId::import) {
                status = open(**directive);
            } else {
                status = reader_.apply(**directive);
            }
            if (!status) return with_excerpt(status.error());
        }
        Result<SceneDescription> scene = reader_.finish(end);
        if (!scene) return with_excerpt(scene.error());
        return scene;
    }

  private:
    [[nodiscard]] SearchPath search() const { return {folder_, fs::path(sources_.back()->path).parent_path()}; }

    void push(const std::string& path, const std::string& identity, std::shared_ptr<const std::string> text,
              bool imported) {
        sources_.push_back(std::make_unique<Source>(path, identity, std::move(text)));
        sources_.back()->imported = imported;
        moved_on_ = true;
    }

    Status open(const Directive& directive) {
        const bool imported = directive.id == DirectiveId::import;
        if (imported)
            if (Status status = reader_.begin_import(directive); !status) return status;
        const SourceLocation& where = directive.string_locations[0];
        const Result<std::string> path = search().find(directive.strings[0], where);
        if (!path) return path.error();
        const std::string identity = identity_of(*path);
        for (const auto& source : sources_)
            if (source->identity == identity)
                return error_at(where, "'" + directive.strings[0] + "' includes itself, by way of " +
                                           std::to_string(sources_.size()) + " open file(s)");
        auto text = text_of(*path, identity, where);
        if (!text) return text.error();
        push(*path, identity, std::move(*text), imported);
        return success();
    }

    /// Reads on across the ends of files. The text of an included file replaces its Include: a file may end within the
    /// parameters of a directive, which the including file then continues.
    Status read_on(Directive& directive) {
        while (takes_parameters(directive) && sources_.size() > 1 && !sources_.back()->imported) {
            Tokenizer& tokenizer = sources_.back()->tokenizer;
            const Result<Token> next = tokenizer.next();
            if (!next) return next.error();
            tokenizer.push_back(*next);
            if (next->kind != TokenKind::end) break;
            if (Status s = pop(); !s) return s;
            if (Status s = parse_more_parameters(sources_.back()->tokenizer, directive); !s) return s;
        }
        return success();
    }

    /// The content of a file; a file that is included again is not read again. Files that include others several times
    /// each grow exponentially, so their number, depth and repeated bytes have budgets.
    Result<std::shared_ptr<const std::string>> text_of(const std::string& path, const std::string& identity,
                                                       const SourceLocation& where) {
        const auto refuse = [&](Budget which, const std::string& what) {
            return over_budget(which, what, where.file, where.line, where.column);
        };
        if (++opened_ > budget(Budget::include_files))
            return refuse(Budget::include_files, "the scene includes too many files");
        if (sources_.size() >= budget(Budget::include_depth))
            return refuse(Budget::include_depth, "files include one another too deep");
        if (const auto known = texts_.find(identity); known != texts_.end()) {
            repeated_bytes_ += known->second->size();
            if (repeated_bytes_ > budget(Budget::include_repeats))
                return refuse(Budget::include_repeats, "the scene includes the same files too many times");
            return known->second;
        }
        Result<std::string> text = read_file(path, NamedBy::file, "a scene file");
        if (!text) {
            Error error = text.error();
            error.hint += (error.hint.empty() ? "" : "; ") + std::string("named at ") + where.file + ":" +
                          std::to_string(where.line) + ":" + std::to_string(where.column);
            return error;
        }
        auto shared = std::make_shared<const std::string>(std::move(*text));
        texts_.emplace(identity, shared);
        return shared;
    }

    Status pop() {
        const bool imported = sources_.back()->imported;
        Status status = imported ? reader_.end_import() : success();
        if (!status) return status;
        // for excerpts of errors that are found at the end
        closed_.try_emplace(sources_.back()->path, sources_.back()->text);
        sources_.pop_back();
        moved_on_ = true;
        return success();
    }

    /// The position after the last line.
    static SourceLocation end_of(Source& source) {
        const Result<Token> token = source.tokenizer.next();
        return token ? source.tokenizer.location(*token) : SourceLocation{source.path, 0, 0};
    }

    /// Adds an excerpt to errors of the builder, which contain the position only.
    [[nodiscard]] Error with_excerpt(Error error) const {
        if (error.line == 0 || !error.excerpt.empty()) return error;
        for (const auto& source : sources_)
            if (source->path == error.file) error.excerpt = excerpt_of(*source->text, error.line);
        if (const auto closed = closed_.find(error.file); closed != closed_.end())
            error.excerpt = excerpt_of(*closed->second, error.line);
        return error;
    }

    SceneReader reader_;
    fs::path folder_;
    std::vector<std::unique_ptr<Source>> sources_;                              ///< open files, the innermost last
    std::map<std::string, std::shared_ptr<const std::string>> closed_, texts_;  ///< by path, by identity
    std::uint64_t opened_ = 0, repeated_bytes_ = 0;
    bool moved_on_ = false;  ///< the current file is not the one whose search path reader_ has
};

}  // namespace

Result<SceneDescription> import_pbrt(const std::string& path, const ImportOptions& options) {
    Result<std::string> text = read_file(path, NamedBy::file, "a pbrt-v4 scene");
    if (!text) return text.error();
    return Importer(path, std::move(*text), options).run();
}

Result<SceneDescription> import_pbrt_text(const std::string& text, const std::string& virtual_path,
                                          const ImportOptions& options) {
    return Importer(virtual_path, text, options).run();
}

}  // namespace raylex::transport
