// Reads a parameter set in one breath: the first error is kept, later reads give fallbacks, and the caller asks once.
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
    /// Takes the value out of `result`, or keeps its error and gives `fallback`.
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
    /// Between `least` and `most`, or an Error that names the range.
    Real real(std::string_view name, Real fallback, Real least, Real most);
    int integer(std::string_view name, int fallback, int least, int most);
    bool boolean(std::string_view name, bool fallback) { return take(set_.boolean_or(name, fallback), fallback); }
    std::string string(std::string_view name, std::string_view fallback) {
        return take(set_.string_or(name, fallback), std::string(fallback));
    }
    /// A string out of `known`; the position of what was found.
    std::size_t choice(std::string_view name, const std::vector<std::string>& known, std::size_t fallback);

    /// Where `parameter` stands, or the whole set when that is not known.
    [[nodiscard]] const SourceLocation& where(const Parameter& parameter) const {
        return parameter.location.line != 0 ? parameter.location : set_.location;
    }

  private:
    [[nodiscard]] const SourceLocation& place_of(std::string_view name) const;
    const ParameterSet& set_;
    std::optional<Error> error_;
};

}  // namespace raylex::transport
