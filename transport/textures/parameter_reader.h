// Reads a parameter set: it keeps the first error, later reads return fallbacks, and the caller checks once at the end.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/services/parameters.h"
#include "transport/math/real.h"

namespace raylex::transport {

class ParameterReader {
  public:
    explicit ParameterReader(const ParameterSet& set) : set_(set) {}

    [[nodiscard]] const ParameterSet& set() const { return set_; }
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }
    void fail(Error error) {
        if (!error_) error_ = std::move(error);
    }
    /// Returns the value of `result`, or keeps its error and returns `fallback`.
    template <class T>
    T take(Result<T> result, T fallback) {
        if (result) return *std::move(result);
        fail(std::move(result).error());
        return fallback;
    }

    Real real(std::string_view name, Real fallback) {
        return static_cast<Real>(
            take(set_.real_or(name, static_cast<double>(fallback)), static_cast<double>(fallback)));
    }
    /// A number between `least` and `most`, or an Error that names the range.
    Real real(std::string_view name, Real fallback, Real least, Real most);
    int integer(std::string_view name, int fallback, int least, int most);
    bool boolean(std::string_view name, bool fallback) { return take(set_.boolean_or(name, fallback), fallback); }
    std::string string(std::string_view name, std::string_view fallback) {
        return take(set_.string_or(name, fallback), std::string(fallback));
    }
    /// The index in `known` of a string parameter.
    std::size_t choice(std::string_view name, const std::vector<std::string>& known, std::size_t fallback);

    /// The position of `parameter`, or of the whole set if it is unknown.
    [[nodiscard]] const SourceLocation& where(const Parameter& parameter) const {
        return parameter.location.line != 0 ? parameter.location : set_.location;
    }

  private:
    [[nodiscard]] const SourceLocation& place_of(std::string_view name) const;
    const ParameterSet& set_;
    std::optional<Error> error_;
};

}  // namespace raylex::transport
