// Errors as values. Every function of the toolkit that reads user input (an expression, a scene, a job, an image)
// returns Result<T>. Exceptions stay inside third-party libraries and never leave a folder.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace raylex {

/// The error, its position and what was expected. `line` and `column` count from 1; 0 means unknown. `column` counts
/// bytes.
struct Error {
    std::string message;  ///< one sentence that names what was found and what was expected
    std::string file;     ///< path, or a description such as "--lpe caustics"; empty when there is none
    int line = 0;
    int column = 0;
    std::string excerpt;  ///< the line of text with the error; printed with a caret under `column`
    std::string hint;     ///< near misses, look-alike letters, a suggestion

    /// "file:line:column: message", then the excerpt with its caret and the hint, one line each.
    [[nodiscard]] std::string to_string() const;
};

/// Either a value or an Error. `if (result) use(*result); else report(result.error());`
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] bool ok() const noexcept { return content_.index() == 0; }
    explicit operator bool() const noexcept { return ok(); }
    T& operator*() & { return std::get<0>(content_); }
    const T& operator*() const& { return std::get<0>(content_); }
    T&& operator*() && { return std::get<0>(std::move(content_)); }
    T* operator->() { return &std::get<0>(content_); }
    const T* operator->() const { return &std::get<0>(content_); }
    [[nodiscard]] const Error& error() const& { return std::get<1>(content_); }
    [[nodiscard]] Error&& error() && { return std::get<1>(std::move(content_)); }

  private:
    std::variant<T, Error> content_;
};

/// A Result without a value.
using Status = Result<std::monostate>;
inline Status success() {
    return Status(std::monostate{});
}

}  // namespace raylex
