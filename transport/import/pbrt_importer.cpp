#include "transport/import/pbrt_importer.h"

#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "transport/import/input_file.h"
#include "transport/import/parser.h"
#include "transport/import/scene_builder.h"

namespace raylex::transport {

namespace fs = std::filesystem;

namespace {

/// One open scene file.
struct Source {
    std::string path, identity;  // identity: the same for every way to write the path
    std::string text;
    Tokenizer tokenizer;
    bool imported = false;

    Source(std::string file, std::string id, std::string content)
        : path(std::move(file)), identity(std::move(id)), text(std::move(content)), tokenizer(text, path) {}
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
    Importer(const std::string& path, std::string text) : builder_(path), folder_(fs::path(path).parent_path()) {
        push(path, std::move(text), false);
    }

    Result<SceneDescription> run() {
        SourceLocation end{sources_.front()->path, 1, 1};
        while (!sources_.empty()) {
            Source& source = *sources_.back();
            Result<std::optional<Directive>> directive = parse_directive(source.tokenizer);
            if (!directive) return directive.error();
            Status status = success();
            if (!directive->has_value()) {
                if (sources_.size() == 1) end = end_of(source);
                status = pop();
            } else if ((*directive)->id == DirectiveId::include || (*directive)->id == DirectiveId::import) {
                status = open(**directive);
            } else {
                status = builder_.apply(**directive, search());
            }
            if (!status) return with_excerpt(status.error());
        }
        Result<SceneDescription> scene = builder_.finish(end);
        if (!scene) return with_excerpt(scene.error());
        return scene;
    }

  private:
    [[nodiscard]] SearchPath search() const { return {folder_, fs::path(sources_.back()->path).parent_path()}; }

    void push(const std::string& path, std::string text, bool imported) {
        sources_.push_back(std::make_unique<Source>(path, identity_of(path), std::move(text)));
        sources_.back()->imported = imported;
    }

    Status open(const Directive& directive) {
        const bool imported = directive.id == DirectiveId::import;
        if (imported)
            if (Status status = builder_.begin_import(directive); !status) return status;
        const SourceLocation& where = directive.string_locations[0];
        const Result<std::string> path = search().find(directive.strings[0], where);
        if (!path) return path.error();
        const std::string identity = identity_of(*path);
        for (const auto& source : sources_)
            if (source->identity == identity)
                return error_at(where, "'" + directive.strings[0] + "' includes itself, by way of " +
                                           std::to_string(sources_.size()) + " open file(s)");
        Result<std::string> text = read_file(*path);
        if (!text) {
            Error error = text.error();
            error.hint +=
                "named at " + where.file + ":" + std::to_string(where.line) + ":" + std::to_string(where.column);
            return error;
        }
        push(*path, std::move(*text), imported);
        return success();
    }

    Status pop() {
        const bool imported = sources_.back()->imported;
        Status status = imported ? builder_.end_import() : success();
        if (!status) return status;
        closed_.push_back(std::move(sources_.back()));
        sources_.pop_back();
        return success();
    }

    /// The line behind the last one.
    static SourceLocation end_of(Source& source) {
        const Result<Token> token = source.tokenizer.next();
        return token ? source.tokenizer.location(*token) : SourceLocation{source.path, 0, 0};
    }

    /// Errors of the builder know the place alone; the texts are kept here.
    [[nodiscard]] Error with_excerpt(Error error) const {
        if (error.line == 0 || !error.excerpt.empty()) return error;
        for (const auto* list : {&sources_, &closed_})
            for (const auto& source : *list)
                if (source->path == error.file) error.excerpt = excerpt_of(source->text, error.line);
        return error;
    }

    SceneBuilder builder_;
    fs::path folder_;
    std::vector<std::unique_ptr<Source>> sources_;  ///< open, the innermost last
    std::vector<std::unique_ptr<Source>> closed_;   ///< for excerpts of errors found at the end
};

}  // namespace

Result<SceneDescription> import_pbrt(const std::string& path) {
    Result<std::string> text = read_file(path);
    if (!text) return text.error();
    return Importer(path, std::move(*text)).run();
}

Result<SceneDescription> import_pbrt_text(const std::string& text, const std::string& virtual_path) {
    return Importer(virtual_path, text).run();
}

}  // namespace raylex::transport
