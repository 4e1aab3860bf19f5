// A renderer of its own on raylex's language, display services and frame buffer: rays against spheres and a plane, a
// path tracer with multiple importance sampling, and nothing of raylex::transport. It moves a tracker along each path,
// reports every contribution once, and gets the shipped partition, a split by light group, and normals. Where
// raylex::display is there too, the image is written as OpenEXR and judged by `raylex verify`.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/pixel_filter.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "lpe/shipped.h"
#ifdef OUTSIDE_WITH_DISPLAY
#include "display/output/writer/exr_writer.h"
#endif

namespace {

using namespace raylex;
using display::Technique;

struct Vector {
    float x = 0, y = 0, z = 0;
};
Vector operator+(Vector a, Vector b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vector operator-(Vector a, Vector b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vector operator*(Vector a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
float dot(Vector a, Vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector normalized(Vector a) {
    return a * (1 / std::sqrt(dot(a, a)));
}
Vector reflected(Vector v, Vector n) {
    return n * (2 * dot(v, n)) - v;
}

constexpr float pi = 3.14159265f, far_away = 1e30f;
constexpr int width = 64, height = 48, samples_per_pixel = 64, block = 16, max_depth = 5;

/// The direction around `axis` with this cosine and azimuth.
Vector around(Vector axis, float cosine, float phi) {
    const Vector helper = std::abs(axis.x) > 0.5f ? Vector{0, 1, 0} : Vector{1, 0, 0};
    const Vector s = normalized(helper - axis * dot(helper, axis));
    const Vector t{axis.y * s.z - axis.z * s.y, axis.z * s.x - axis.x * s.z, axis.x * s.y - axis.y * s.x};
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return s * (sine * std::cos(phi)) + t * (sine * std::sin(phi)) + axis * cosine;
}

/// PCG32 (O'Neill 2014), seeded by the sample, so that the image does not depend on the order of samples.
struct Random {
    std::uint64_t state;
    float next() {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const auto word = static_cast<std::uint32_t>(((state >> 18) ^ state) >> 27);
        const auto turn = static_cast<std::uint32_t>(state >> 59);
        return static_cast<float>(((word >> turn) | (word << ((32 - turn) & 31))) >> 8) * 0x1p-24f;
    }
};

struct Ray {
    Vector origin, direction;
};

/// A sphere, or with radius 0 the plane y = center.y.
struct Object {
    const char* label;
    Vector center;
    float radius;
    Rgb diffuse, glossy;  ///< Lambert and normalised Phong, on one surface
    float exponent = 30;
    Rgb mirror, emission;
    lpe::EventClass diffuse_event = 0, glossy_event = 0, mirror_event = 0;
};

std::vector<Object> scene{{"floor", {0, -1, 0}, 0, Rgb(0.5f, 0.45f, 0.4f), Rgb(), 0, Rgb(), Rgb()},
                          {"plastic", {-1.1f, 0, 5}, 1, Rgb(0.5f, 0.1f, 0.1f), Rgb(0.4f), 30, Rgb(), Rgb()},
                          {"mirror", {1.2f, 0, 5.5f}, 1, Rgb(), Rgb(), 0, Rgb(0.9f), Rgb()},
                          {"lamp", {0.5f, 2.5f, 3.5f}, 0.5f, Rgb(), Rgb(), 0, Rgb(), Rgb(12)}};
const std::size_t lamp = 3;
Rgb sky(Vector d) {
    return Rgb(0.3f, 0.4f, 0.6f) * (0.5f + 0.5f * std::max(0.0f, d.y));
}

float distance_to(const Object& object, const Ray& ray) {
    if (object.radius == 0) {
        const float t = (object.center.y - ray.origin.y) / ray.direction.y;
        return t > 1e-3f ? t : far_away;
    }
    const Vector to = object.center - ray.origin;
    const float b = dot(to, ray.direction), root = b * b - dot(to, to) + object.radius * object.radius;
    if (root < 0) return far_away;
    const float near = b - std::sqrt(root), behind = b + std::sqrt(root);
    return near > 1e-3f ? near : behind > 1e-3f ? behind : far_away;
}

std::size_t nearest(const Ray& ray, float& t) {
    std::size_t found = scene.size();
    t = far_away;
    for (std::size_t i = 0; i < scene.size(); ++i)
        if (const float each = distance_to(scene[i], ray); each < t) t = each, found = i;
    return found;
}

/// Density of the cone that the lamp fills as seen from a point, per steradian; 1 less the cosine of its half angle, in
/// a form that is exact for lamps far away too.
float lamp_density(Vector from, float& width_of_cone) {
    const Vector to = scene[lamp].center - from;
    const float sine2 = scene[lamp].radius * scene[lamp].radius / dot(to, to);
    width_of_cone = sine2 / (1 + std::sqrt(1 - sine2));
    return 1 / (2 * pi * width_of_cone);
}
float power_heuristic(float p, float q) {
    return p * p / (p * p + q * q);
}

/// f |cos| of both lobes, and the density of choosing wi.
struct Scattered {
    Rgb diffuse, glossy;
    float density = 0;
};
float diffuse_share(const Object& o) {
    return o.glossy.is_black() ? 1.0f : o.diffuse.is_black() ? 0.0f : 0.5f;
}
Scattered scattering(const Object& o, Vector n, Vector wo, Vector wi) {
    const float cosine = dot(n, wi), lobe = std::pow(std::max(0.0f, dot(reflected(wo, n), wi)), o.exponent);
    if (cosine <= 0) return {};
    return {o.diffuse * (cosine / pi), o.glossy * ((o.exponent + 2) / (2 * pi) * lobe * cosine),
            diffuse_share(o) * cosine / pi + (1 - diffuse_share(o)) * (o.exponent + 1) / (2 * pi) * lobe};
}

struct Tracer {
    display::DisplayServices& services;
    display::LpeServices& lpe;
    display::ChannelId normals;
    lpe::EventClass key_light, sky_light;

    void move(display::Tracker& path, const Object& o, const Scattered& f) {
        const std::array parts{display::LobePart{o.diffuse_event, f.diffuse},
                               display::LobePart{o.glossy_event, f.glossy}};
        lpe.move(path, parts);
    }

    void trace(int row, Ray ray, Random random) {
        display::Tracker path = lpe.begin(row);
        Rgb throughput(1);
        float density = 0, cone = 0;  // density 0: the last direction was the only one possible
        for (int depth = 0;; ++depth) {
            float t;
            const std::size_t hit = nearest(ray, t);
            if (hit == scene.size()) {
                lpe.move(path, sky_light);
                return lpe.contribute(throughput * sky(ray.direction), Technique{}, path);
            }
            const Object& o = scene[hit];
            const Vector point = ray.origin + ray.direction * t, wo = ray.direction * -1;
            Vector n = o.radius == 0 ? Vector{0, 1, 0} : normalized(point - o.center);
            if (dot(n, wo) < 0) n = n * -1;
            if (depth == 0) {
                services.write(normals, row, Rgb(n.x, n.y, n.z));
                services.write_distance(row, t);
                services.write_opacity(row, 1.0f);
            }
            if (!o.emission.is_black()) {
                const float weight = density == 0 ? 1 : power_heuristic(density, lamp_density(ray.origin, cone));
                lpe.move(path, key_light);
                return lpe.contribute(throughput * o.emission * weight, Technique{}, path);
            }
            if (depth == max_depth) return;
            if (!o.mirror.is_black()) {
                lpe.move(path, o.mirror_event);
                throughput *= o.mirror;
                density = 0;
                ray = {point, reflected(wo, n)};
            } else {
                const float lamp_pdf = lamp_density(point, cone);
                const float aim = 1 - random.next() * cone, turn = 2 * pi * random.next();
                const Ray to_lamp{point, around(normalized(scene[lamp].center - point), aim, turn)};
                const Scattered lit = scattering(o, n, wo, to_lamp.direction);
                if (lit.density > 0 && nearest(to_lamp, t) == lamp) {
                    display::Tracker branch = path;
                    move(branch, o, lit);
                    lpe.move(branch, key_light);
                    const float weight = power_heuristic(lamp_pdf, lit.density) / lamp_pdf;
                    lpe.contribute(throughput * (lit.diffuse + lit.glossy) * scene[lamp].emission * weight,
                                   Technique{1, 2}, branch);
                }
                const bool diffuse = random.next() < diffuse_share(o);
                const float u = random.next(), v = 2 * pi * random.next();
                const Vector wi = diffuse ? around(n, std::sqrt(u), v)
                                          : around(reflected(wo, n), std::pow(u, 1 / (o.exponent + 1)), v);
                const Scattered f = scattering(o, n, wo, wi);
                if (!(f.density > 0)) return;
                move(path, o, f);
                throughput *= (f.diffuse + f.glossy) / f.density;
                density = f.density;
                ray = {point, wi};
            }
            if (!lpe.live(path)) return;  // nothing asked for can still accept
        }
    }
};

display::ChannelDefinition light_channel(std::string name, std::string expression) {
    display::ChannelDefinition channel;
    channel.name = std::move(name);
    channel.style = display::ChannelStyle::expression;
    channel.expression = std::move(expression);
    return channel;
}

int fail(const Error& error) {
    return std::fprintf(stderr, "%s\n", error.to_string().c_str()), 1;
}

/// Largest |sum of layers - beauty| over its bound, 1e-12 of all that was added, in the frame buffer's doubles (Law 1).
double worst_residual(const display::FrameBuffer& image, const std::vector<display::ChannelId>& layers) {
    const std::vector<double> beauty = image.resolve(0);
    std::vector<double> sum(beauty.size()), scale(beauty.size(), 1e-12);
    for (const display::ChannelId id : layers)
        for (std::size_t i = 0; const double value : image.resolve(id)) sum[i] += value, scale[i++] += std::abs(value);
    double worst = 0;
    for (std::size_t i = 0; i < sum.size(); ++i)
        worst = std::max(worst, std::abs(sum[i] - beauty[i]) / (1e-12 * scale[i]));
    return worst;
}

}  // namespace

int main() {
    std::vector<display::ChannelDefinition> channels{light_channel("beauty", "C.*")};
    std::vector<std::string> lobes, groups{"key", "sky"};
    std::vector<display::ChannelId> lobe_ids, group_ids;
    for (const lpe::NamedExpression& each : lpe::shipped_partition()) {
        lobes.emplace_back(each.name);
        lobe_ids.push_back(static_cast<display::ChannelId>(channels.size()));
        channels.push_back(light_channel(std::string(each.name), std::string(each.expression)));
    }
    for (const std::string& group : groups) {
        group_ids.push_back(static_cast<display::ChannelId>(channels.size()));
        channels.push_back(light_channel(group, "C.*<L.'" + group + "'>"));
    }
    const auto normals = static_cast<display::ChannelId>(channels.size());
    display::ChannelDefinition& normal = channels.emplace_back();
    normal.name = "Nn";
    normal.type = display::ChannelType::normal;
    normal.space = "camera";

    const auto setup = display::LpeSetup::build(channels, 0);
    if (!setup) return fail(setup.error());
    using lpe::EventType, lpe::Scatter;
    for (Object& o : scene) {
        o.diffuse_event = setup->classify({EventType::reflection, Scatter::diffuse, 0, {o.label, "diffuse"}});
        o.glossy_event = setup->classify({EventType::reflection, Scatter::glossy, 0, {o.label, "phong"}});
        o.mirror_event = setup->classify({EventType::reflection, Scatter::singular, 0, {o.label, "mirror"}});
    }
    const auto filter = display::make_pixel_filter("gaussian", {});
    if (!filter) return fail(filter.error());
    auto image = display::FrameBuffer::create({.width = width, .height = height, .block_size = block}, channels);
    if (!image) return fail(image.error());

    display::SampleTable table(channels, block);
    display::DisplayServices services(table);
    display::LpeServices paths(*setup, table, 0);
    Tracer tracer{services, paths, normals, setup->classify({EventType::light, Scatter::none, 0, {"key"}}),
                  setup->classify({EventType::background, Scatter::none, 0, {"sky"}})};
    for (int task = 0; task < width * height * (samples_per_pixel / block); ++task) {
        const int pixel = task % (width * height), x = pixel % width, y = pixel / width;
        std::array<display::CameraRow, block> rows;
        std::array<Random, block> random{};
        for (std::size_t i = 0; i < block; ++i) {
            const std::uint64_t sample = static_cast<std::uint64_t>(task / (width * height)) * block + i;
            random[i].state = (sample * width * height + static_cast<std::uint64_t>(pixel)) * 0x9e3779b97f4a7c15u;
            for (int warm = 0; warm < 4; ++warm) random[i].next();
            const float u = random[i].next(), v = random[i].next();
            const display::FilterSample offset = filter->sample(u, v);
            rows[i] = {.pixel_x = x,
                       .pixel_y = y,
                       .screen_x = static_cast<float>(x) + 0.5f + offset.dx,
                       .screen_y = static_cast<float>(y) + 0.5f + offset.dy,
                       .filter_weight = offset.weight,
                       .sample = sample};
        }
        table.begin(rows);
        for (std::size_t i = 0; i < block; ++i) {
            const Vector to{(rows[i].screen_x - width / 2.0f) / height, (height / 2.0f - rows[i].screen_y) / height, 1};
            tracer.trace(static_cast<int>(i), {{0, 0.3f, 0}, normalized(to)}, random[i]);
        }
        image->accumulate(table);
    }

    const double by_lobe = worst_residual(*image, lobe_ids), by_light = worst_residual(*image, group_ids);
    std::printf("foreign renderer: splits off by %.2g and %.2g of the bound\n", by_lobe, by_light);
    bool right = by_lobe <= 1 && by_light <= 1 && paths.invalid_count() == 0;
    for (const display::ChannelId id : {1, 2, 3, 4, 6, 7, 10, 11, 12}) {  // the scene has neither glass nor volumes
        double total = 0;
        for (const double value : image->resolve(id)) total += std::abs(value);
        if (total == 0)
            right = std::printf("layer %s is empty\n", channels[static_cast<std::size_t>(id)].name.c_str()) < 0;
    }
#ifdef OUTSIDE_WITH_DISPLAY
    display::ImageDescription description;
    description.partitions = {{"shipped", "", lobes}, {"lights", "", groups}};
    if (Status written = display::write_exr("foreign.exr", *image, 0, description); !written)
        return fail(written.error());
    right = std::system("\"" OUTSIDE_RAYLEX "\" verify foreign.exr") == 0 && right;
#endif
    return right ? 0 : 1;
}
