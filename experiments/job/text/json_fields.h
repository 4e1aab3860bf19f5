// Converts structs to JSON objects and back. A function visit_fields(visit, object) names each field once:
//     void visit_fields(auto visit, Phase& phase) {
//         visit("name", phase.name);
//         visit.optional("reason", phase.reason, !phase.reason.empty());
//     }
// It stands in namespace raylex::experiments, whatever the namespace of the struct.
#pragma once

#include <array>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/text/json.h"

namespace raylex::experiments {

/// Adds fields to a JSON object. Pairs of texts become an object.
class FieldWriter {
  public:
    explicit FieldWriter(Json& json) : json_(json) {}
    void operator()(const char* name, const auto& value) const { json_[name] = value; }
    void operator()(const char* name, const std::vector<std::pair<std::string, std::string>>& values) const {
        Json& object = json_[name] = Json::object();
        for (const auto& [key, value] : values) object[key] = value;
    }
    void optional(const char* name, const auto& value, bool present) const {
        if (present) (*this)(name, value);
    }

  private:
    Json& json_;
};

template <class T>
concept HasFields = requires(FieldWriter visit, T& object) {
    visit_fields(visit, object);
};

/// Sets fields from a JSON object. Throws Json::exception if a field is missing or has another type. An optional field
/// may be missing, and keeps its value, unless the fields before it require it.
class FieldReader {
  public:
    explicit FieldReader(const Json& json) : json_(json) {}
    void operator()(const char* name, auto&& value) const { read(json_.at(name), value); }
    void optional(const char* name, auto&& value, bool is_required) const {
        if (is_required || json_.contains(name)) (*this)(name, value);
    }

  private:
    template <class T>
    static void read(const Json& json, T& value) {
        if constexpr (std::integral<T> && !std::same_as<T, bool>) value = whole(json);
        else json.get_to(value);
    }
    template <std::size_t n>
    static void read(const Json& json, std::array<int, n>& values) {
        for (std::size_t i = 0; i < n; ++i) read(json.at(i), values[i]);
    }
    template <HasFields T>
    static void read(const Json& json, std::vector<T>& values) {
        for (const Json& each : json) each.get_to(values.emplace_back());
    }
    static void read(const Json& json, std::vector<std::pair<std::string, std::string>>& values) {
        for (const auto& [key, value] : json.items()) values.emplace_back(key, value.get<std::string>());
    }

    const Json& json_;
};

/// Defines visit_fields() for fields whose names in JSON are their own.
#define RAYLEX_JSON_FIELDS(Type, ...)                                             \
    void visit_fields(auto visit, Type& object) {                                 \
        NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(RAYLEX_JSON_FIELD, __VA_ARGS__)) \
    }
#define RAYLEX_JSON_FIELD(field) visit(#field, object.field);

}  // namespace raylex::experiments

/// Makes the conversions of nlohmann/json use visit_fields(), also for vectors of such structs.
template <raylex::experiments::HasFields T>
struct nlohmann::adl_serializer<T> {
    static void to_json(raylex::experiments::Json& json, const T& object) {
        visit_fields(raylex::experiments::FieldWriter(json), const_cast<T&>(object));  // a writer changes no field
    }
    static void from_json(const raylex::experiments::Json& json, T& object) {
        visit_fields(raylex::experiments::FieldReader(json), object);
    }
};
