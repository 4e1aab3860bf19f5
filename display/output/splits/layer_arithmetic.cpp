#include "display/output/splits/layer_arithmetic.h"

#include <algorithm>
#include <string_view>

#include "display/output/reader/exr_layers.h"
#include "display/output/splits/split_check.h"
#include "display/services/parameters.h"

namespace raylex::display {

std::string name_of(const ImageLayer& layer) {
    return layer.name.empty() ? "beauty" : layer.name;
}

namespace {

using Kind = SumStep::Kind;
constexpr int deepest_nesting = 64;  // far more than anyone writes; the parser is recursive

// True for "diffuse_*" and "?", but not for "DiffDir*DiffCol": it has wildcards and cannot be a product of names.
bool only_a_glob(const std::string& item) {
    if (item.find_first_of("()+'\" \t") != std::string::npos) return false;
    return item.find('?') != std::string::npos || item.starts_with('*') || item.ends_with('*') ||
           item.find("**") != std::string::npos;
}

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n';
}
bool ends_name(char c) {
    return is_space(c) || std::string_view("()+-*,'\"").find(c) != std::string_view::npos;
}

// Parses one text. Positions are offsets in it; a failed Status ends parsing.
class SumParser {
  public:
    SumParser(const ExrImage& image, const ImageLayer& of, LayerSum& sum) : image_(image), of_(of), sum_(sum) {}

    Status items(const std::string& text) {
        text_ = text;
        at_ = 0;
        for (;;) {
            skip_space();
            if (Status read = item(); !read) return read;
            if (at_ >= text_.size()) return success();
            ++at_;  // the comma
        }
    }

    /// The number of values on the stack that must be added up.
    [[nodiscard]] int count() const { return count_; }

  private:
    Error error_here(const std::string& message, std::size_t position, const std::string& hint = {}) const {
        Error error = error_at({"--sum", 0, static_cast<int>(position) + 1}, message, hint);
        error.excerpt = text_;
        return error;
    }

    Error located(const Error& error, std::size_t position) const {
        return error_here(error.message + " (" + image_.path + ")", position, error.hint);
    }

    void skip_space() {
        while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    }

    // The end of the item that begins here: at a comma outside quotes.
    [[nodiscard]] std::size_t item_end() const {
        char quote = 0;
        for (std::size_t i = at_; i < text_.size(); ++i) {
            if (quote != 0) quote = text_[i] == quote ? char{0} : quote;
            else if (text_[i] == '\'' || text_[i] == '"') quote = text_[i];
            else if (text_[i] == ',') return i;
        }
        return text_.size();
    }

    void push(const ImageLayer& layer) {
        sum_.steps.push_back({Kind::layer, &layer, 0});
        if (std::find(sum_.layers.begin(), sum_.layers.end(), &layer) == sum_.layers.end())
            sum_.layers.push_back(&layer);
    }

    void push_once(const ImageLayer& layer) {
        if (std::find(alone_.begin(), alone_.end(), &layer) != alone_.end()) return;
        alone_.push_back(&layer);
        push(layer);
        add_item();
    }

    // Adds from left to right, like the writers of files.
    void add_item() {
        if (++count_ > 1) sum_.steps.push_back({Kind::add, nullptr, 0});
    }

    Error refuse_whole(std::size_t position) const {
        return error_here("layer '" + name_of(of_) + "' is the sum itself; expected layers that it splits into",
                          position);
    }

    Status item() {
        const std::size_t begin = at_, end = item_end();
        std::string content = text_.substr(begin, end - begin);
        content.erase(content.find_last_not_of(" \t\n") + 1);
        if (content.empty())
            return error_here(
                "this item is empty; expected a layer, a glob or an expression such as "
                "(DiffDir+DiffInd)*DiffCol; the layers are: " +
                    list_names(image_.layer_names()),
                begin);
        // Names take precedence, whatever their characters; then globs; everything else is arithmetic.
        if (Result<const ImageLayer*> layer = resolve_layer(image_, content, of_.name)) {
            if (*layer == &of_) return refuse_whole(begin);
            push_once(**layer);
        } else if (content.find_first_of("*?") == std::string::npos || !add_glob(content)) {
            return arithmetic(content, end);
        }
        at_ = end;
        return success();
    }

    bool add_glob(const std::string& glob) {
        const std::vector<const ImageLayer*> matches = layers_like(image_, glob, of_.name);
        for (const ImageLayer* layer : matches)
            if (layer != &of_) push_once(*layer);
        return std::any_of(matches.begin(), matches.end(), [this](const ImageLayer* layer) { return layer != &of_; });
    }

    Status arithmetic(const std::string& content, std::size_t end) {
        const std::size_t begin = at_;
        end_ = end;
        Status read = sum(0);
        if (read && at_ < end_)
            read = error_here("'" + text_.substr(at_, 1) + "' is unexpected here; expected + - * or a comma", at_);
        if (read) {
            add_item();
            return success();
        }
        if (!only_a_glob(content)) return read;
        const Error unknown = resolve_layer(image_, content, of_.name).error();
        return error_here("no layer matches '" + content + "' (" + image_.path +
                              "); expected one of: " + list_names(image_.layer_names()),
                          begin, unknown.hint);
    }

    Status sum(int nesting) {
        if (nesting > deepest_nesting)
            return error_here("more than " + std::to_string(deepest_nesting) + " brackets are open; expected fewer",
                              at_);
        int additions = 0;
        if (Status first = product(nesting); !first) return first;
        for (skip_space(); at_ < end_ && (text_[at_] == '+' || text_[at_] == '-'); skip_space(), ++additions) {
            const bool minus = text_[at_++] == '-';
            if (Status next = product(nesting); !next) return next;
            sum_.steps.push_back({minus ? Kind::subtract : Kind::add, nullptr, 0});
        }
        if (additions > 0) sum_.steps.push_back({Kind::rounded, nullptr, additions});
        sum_.additions += additions;
        return success();
    }

    Status product(int nesting) {
        if (Status first = factor(nesting); !first) return first;
        for (skip_space(); at_ < end_ && text_[at_] == '*'; skip_space()) {
            ++at_;
            if (Status next = factor(nesting); !next) return next;
            sum_.steps.push_back({Kind::multiply, nullptr, 0});
            ++sum_.products;
        }
        return success();
    }

    Status factor(int nesting) {
        skip_space();
        bool minus = false;
        for (; at_ < end_ && (text_[at_] == '-' || text_[at_] == '+'); skip_space()) minus ^= text_[at_++] == '-';
        if (at_ >= end_ || text_[at_] == ')' || text_[at_] == '*')
            return error_here("expected a layer or ( here; a glob such as diffuse_* must be alone between commas", at_);
        if (text_[at_] == '(') {
            const std::size_t open = at_++;
            if (Status inner = sum(nesting + 1); !inner) return inner;
            if (at_ >= end_ || text_[at_] != ')') return error_here("this bracket is never closed; expected )", open);
            ++at_;
        } else if (Status read = name(); !read) {
            return read;
        }
        if (minus) sum_.steps.push_back({Kind::negate, nullptr, 0});
        return success();
    }

    Status name() {
        const std::size_t begin = at_;
        std::string text;
        if (text_[at_] == '\'' || text_[at_] == '"') {
            const std::size_t close = text_.find(text_[at_], at_ + 1);
            if (close == std::string::npos || close >= end_)
                return error_here("this quote is never closed; expected " + text_.substr(at_, 1), begin);
            text = text_.substr(at_ + 1, close - at_ - 1);
            at_ = close + 1;
        } else {
            std::size_t length = longest_known();
            if (length == 0)
                while (at_ + length < end_ && !ends_name(text_[at_ + length])) ++length;
            text = text_.substr(at_, length);
            at_ += length;
        }
        Result<const ImageLayer*> layer = resolve_layer(image_, text, of_.name);
        if (!layer) return located(std::move(layer).error(), begin);
        if (*layer == &of_) return refuse_whole(begin);
        push(**layer);
        return success();
    }

    // The length of the longest layer name, with or without its prefix, that is here and ends where a name can end.
    [[nodiscard]] std::size_t longest_known() const {
        std::size_t longest = 0;
        const std::string_view rest = std::string_view(text_).substr(at_, end_ - at_);
        for (const std::string& known : spoken_names(image_))
            if (known.size() > longest && rest.starts_with(known) &&
                (known.size() == rest.size() || ends_name(rest[known.size()])))
                longest = known.size();
        return longest;
    }

    const ExrImage& image_;
    const ImageLayer& of_;
    LayerSum& sum_;
    std::string text_;
    std::size_t at_ = 0, end_ = 0;
    int count_ = 0;
    std::vector<const ImageLayer*> alone_;
};

// Ends a sum of `count` items, and computes the maximum depth of the stack.
void close_sum(LayerSum& sum, int count) {
    if (count > 1) sum.steps.push_back({Kind::rounded, nullptr, count - 1});
    sum.additions += std::max(0, count - 1);
    int waiting = 0;
    for (const SumStep& step : sum.steps) {
        if (step.kind == Kind::layer) ++waiting;
        else if (step.kind != Kind::negate && step.kind != Kind::rounded) --waiting;
        sum.depth = std::max(sum.depth, waiting);
    }
}

}  // namespace

Result<LayerSum> parse_sum(const ExrImage& image, const ImageLayer& of, const std::vector<std::string>& texts) {
    LayerSum sum;
    SumParser parser(image, of, sum);
    for (const std::string& text : texts)
        if (Status read = parser.items(text); !read) return std::move(read).error();
    if (parser.count() == 0)
        return error_at({image.path, 0, 0},
                        "no layers to sum; expected at least one of: " + list_names(image.layer_names()));
    close_sum(sum, parser.count());
    return sum;
}

LayerSum sum_of_layers(const std::vector<const ImageLayer*>& layers) {
    LayerSum sum;
    for (const ImageLayer* layer : layers) {
        sum.steps.push_back({Kind::layer, layer, 0});
        if (sum.steps.size() > 1) sum.steps.push_back({Kind::add, nullptr, 0});
    }
    sum.layers = layers;
    close_sum(sum, static_cast<int>(layers.size()));
    return sum;
}

}  // namespace raylex::display
