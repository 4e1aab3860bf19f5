// All kinds of pbrt's curves are stored as cubic Bezier segments ("Physically Based Rendering", 4th edition, 6.7): the
// degree of quadratic ones is raised, and pieces of uniform B-splines get the control points of their blossoms.
#include "transport/import/shapes/curve_shapes.h"

#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "transport/import/shapes/shape_parameters.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {
namespace {

/// The string parameters of a curve.
struct CurveWords {
    CurveType type = CurveType::flat;
    bool bspline = false;
    int degree = 3;
    float width0 = 1, width1 = 1;
};

/// Returns the index of the parameter's value in `choices`. For any other value returns `otherwise` with a warning, if
/// pbrt-v4 continues with that one, else an error.
Result<std::size_t> choice(const ParameterSet& set, std::string_view name, std::initializer_list<const char*> choices,
                           std::optional<std::size_t> otherwise, std::vector<Error>& warnings) {
    const Result<std::string> word = set.string_or(name, *choices.begin());
    if (!word) return word.error();
    std::size_t i = 0;
    std::string list;
    for (const char* each : choices) {
        if (*word == each) return i;
        list += (i++ == 0 ? "" : i == choices.size() ? " or " : ", ") + std::string(each);
    }
    Error unknown =
        error_at(location_of(set, name), "'" + std::string(name) + "' of a curve is '" + *word + "'; expected " + list);
    if (!otherwise) return unknown;
    unknown.message += std::string(". It is read as ") + choices.begin()[*otherwise] + ", as in pbrt-v4";
    warnings.push_back(std::move(unknown));
    return *otherwise;
}

Result<float> width_of(const ParameterSet& set, const char* name, float fallback) {
    const Result<double> width = set.real_or(name, static_cast<double>(fallback));
    if (!width) return width.error();
    const float value = static_cast<float>(*width);
    if (!(value >= 0) || !std::isfinite(value))
        return error_at(location_of(set, name), "'" + std::string(name) +
                                                    "' of a curve is negative or not finite; "
                                                    "expected a length of at least 0");
    return value;
}

Result<CurveWords> read_words(const ParameterSet& set, std::vector<Error>& warnings) {
    CurveWords words;
    const Result<std::size_t> type = choice(set, "type", {"flat", "cylinder", "ribbon"}, 1, warnings);
    if (!type) return type.error();
    words.type = static_cast<CurveType>(*type);
    const Result<std::size_t> basis = choice(set, "basis", {"bezier", "bspline"}, std::nullopt, warnings);
    if (!basis) return basis.error();
    words.bspline = *basis == 1;
    const Result<std::int64_t> degree = set.integer_or("degree", 3);
    if (!degree) return degree.error();
    if (*degree != 2 && *degree != 3)
        return error_at(location_of(set, "degree"),
                        "'degree' of a curve is " + std::to_string(*degree) + "; expected 2 or 3");
    words.degree = static_cast<int>(*degree);
    const Result<float> width = width_of(set, "width", 1);
    if (!width) return width.error();
    const Result<float> width0 = width_of(set, "width0", *width), width1 = width_of(set, "width1", *width);
    if (!width0) return width0.error();
    if (!width1) return width1.error();
    words.width0 = *width0;
    words.width1 = *width1;
    return words;
}

Result<std::size_t> count_segments(const ParameterSet& set, const CurveWords& words, std::size_t points) {
    const auto degree = static_cast<std::size_t>(words.degree);
    if (words.bspline ? points > degree : points > degree && (points - 1) % degree == 0)
        return words.bspline ? points - degree : (points - 1) / degree;
    const std::string least = std::to_string(degree + 1);
    return error_at(location_of(set, "P"), "curve has " + std::to_string(points) + " control points; a " +
                                               (words.bspline ? "B-spline" : "Bezier") + " curve of degree " +
                                               std::to_string(degree) + " expected " + least +
                                               (words.bspline ? " or more" : " + " + std::to_string(degree) + " n"));
}

/// Appends the cubic control points of one segment with the control points `p`; the first is shared with the previous
/// segment.
void append_segment(std::vector<StoredVec3>& out, const StoredVec3* p, const CurveWords& words) {
    DVec3 a(p[0]), b(p[1]), c(p[2]), d;
    if (words.degree == 2) {
        if (words.bspline) {
            a = (a + b) * 0.5;
            c = (b + c) * 0.5;
        }
        d = c;
        c = (b * 2 + c) * (1.0 / 3);
        b = (a + b * 2) * (1.0 / 3);
    } else {
        d = DVec3(p[3]);
        if (words.bspline) {
            const DVec3 first = (a + b * 4 + c) * (1.0 / 6), last = (b + c * 4 + d) * (1.0 / 6);
            const DVec3 second = (b * 2 + c) * (1.0 / 3), third = (b + c * 2) * (1.0 / 3);
            a = first, b = second, c = third, d = last;
        }
    }
    const auto add = [&out](const DVec3& v) { out.push_back(to_float(v.to_real())); };
    if (out.empty()) add(a);
    add(b);
    add(c);
    add(d);
}

Result<std::vector<StoredVec3>> read_normals(const ParameterSet& set, const CurveWords& words, std::size_t segments,
                                             std::vector<Error>& warnings) {
    Result<std::vector<StoredVec3>> normals = triples(set, "N", ParameterType::normal, "normal");
    if (!normals) return normals;
    if (words.type != CurveType::ribbon) {
        if (!normals->empty())
            warnings.push_back(
                error_at(location_of(set, "N"), "'N' of a curve applies to ribbons only and is ignored"));
        return std::vector<StoredVec3>();
    }
    if (normals->size() != segments + 1)
        return error_at(location_of(set, "N"),
                        "ribbon of " + std::to_string(segments) + " segments has " + std::to_string(normals->size()) +
                            " normals; expected one at each end of every segment, " + std::to_string(segments + 1));
    for (std::size_t i = 0; i < normals->size(); ++i) {
        const DVec3 n((*normals)[i]);
        if (!is_finite((*normals)[i]) || !(dot(n, n) > 0))
            return error_at(location_of(set, "N"),
                            "normal " + std::to_string(i) + " of a ribbon is zero or not finite; expected a direction");
    }
    return normals;
}

}  // namespace

Result<std::vector<SceneShape>> make_curve(const ParameterSet& set, const ShapeContext& context,
                                           std::vector<Error>& warnings) {
    const Result<CurveWords> words = read_words(set, warnings);
    if (!words) return words.error();
    const Result<std::vector<StoredVec3>> points = triples(set, "P", ParameterType::point3, "point3");
    if (!points) return points.error();
    const Result<std::size_t> segments = count_segments(set, *words, points->size());
    if (!segments) return segments.error();
    Result<std::vector<StoredVec3>> normals = read_normals(set, *words, *segments, warnings);
    if (!normals) return normals.error();
    SceneShape shape;
    shape.kind = ShapeKind::curves;
    shape.location = set.location;
    shape.curve_type = words->type;
    shape.curve_widths = {{words->width0, words->width1}};
    shape.indices = {0};
    shape.normals = std::move(*normals);
    const std::size_t step = words->bspline ? 1 : static_cast<std::size_t>(words->degree);
    shape.positions.reserve(3 * *segments + 1);
    for (std::size_t i = 0; i < *segments; ++i) append_segment(shape.positions, points->data() + i * step, *words);
    shape.object_to_world = context.object_to_world;
    shape.flip_normal = context.reverse_orientation != context.object_to_world.swaps_handedness();
    return std::vector<SceneShape>{std::move(shape)};
}

bool join_curves(SceneShape& group, const SceneShape& next, bool same_material) {
    const auto kept = [](const SceneShape& s) {
        return std::tie(s.kind, s.curve_type, s.flip_normal, s.area_light, s.inside_medium, s.outside_medium, s.alpha,
                        s.alpha_texture, s.label, s.holdout);
    };
    if (next.kind != ShapeKind::curves || !same_material || kept(group) != kept(next) ||
        group.object_to_world.matrix() != next.object_to_world.matrix())
        return false;
    const std::size_t before = group.positions.size();
    if (before + next.positions.size() > 0xffffffffu) return false;
    for (const std::uint32_t first : next.indices) group.indices.push_back(static_cast<std::uint32_t>(before + first));
    group.positions.insert(group.positions.end(), next.positions.begin(), next.positions.end());
    group.normals.insert(group.normals.end(), next.normals.begin(), next.normals.end());
    group.curve_widths.insert(group.curve_widths.end(), next.curve_widths.begin(), next.curve_widths.end());
    return true;
}

}  // namespace raylex::transport
