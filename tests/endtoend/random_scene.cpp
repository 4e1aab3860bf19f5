#include "random_scene.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace soak_test {
namespace {

namespace display = raylex::display;

class SceneWriter {
  public:
    explicit SceneWriter(std::uint64_t index) : random_(index * 2 + 1) {}

    std::string write() {
        head();
        text_ += "WorldBegin\n";
        for (std::size_t i = random_.below(3); i > 0; --i) light();
        if (random_.chance(0.5)) text_ += "LightSource \"infinite\" " + rgb("L", strength()) + "\n";
        if (random_.chance(0.2)) object();
        for (std::size_t i = 1 + random_.below(4); i > 0; --i) {
            text_ += "AttributeBegin\n";
            if (random_.chance(0.6)) transform();
            material();
            if (has_media_ && random_.chance(0.4))
                text_ += std::string("MediumInterface \"fog\" ") + (random_.chance(0.5) ? "\"\"\n" : "\"fog\"\n");
            if (random_.chance(0.3))
                text_ += "AreaLightSource \"diffuse\" " + rgb("L", strength()) +
                         (random_.chance(0.3) ? " \"bool twosided\" true\n" : "\n");
            shape();
            text_ += "AttributeEnd\n";
        }
        return std::move(text_);
    }

  private:
    template <std::size_t n>
    const char* one_of(const std::array<const char*, n>& names) {
        return names[random_.below(n)];
    }
    static std::string number(double v) {
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%.9g ", v);
        return text.data();
    }
    /// Mostly of ordinary size, now and then of any that a float has.
    double size() {
        const double u = random_.unit();
        const double reach = u < 0.65 ? 0.5 : u < 0.85 ? 6 : u < 0.95 ? 17 : 38;
        return std::pow(10.0, random_.between(-reach, reach));
    }
    double strength() { return random_.chance(0.1) ? 0 : size(); }
    double signed_size() {
        if (random_.chance(0.1)) return 0;
        return random_.chance(0.5) ? size() : -size();
    }
    double side() { return random_.chance(0.5) ? 1 : -1; }
    std::string point() { return number(signed_size()) + number(signed_size()) + number(signed_size()); }
    /// All corners of a shape about one place, in one size.
    std::string near(const std::array<double, 3>& place, double spread) {
        std::string text;
        for (const double at : place) text += number(at + spread * random_.between(-1, 1));
        return text;
    }
    std::string real(const std::string& name, double value) { return " \"float " + name + "\" " + number(value); }
    std::string whole(const std::string& name, std::size_t value) {
        return " \"integer " + name + "\" " + std::to_string(value);
    }
    std::string rgb(const std::string& name, double scale) {
        return " \"rgb " + name + "\" [" + number(scale * random_.unit()) + number(scale * random_.unit()) +
               number(scale * random_.unit()) + "]";
    }
    std::string reflectance(const std::string& name) {
        return rgb(name, random_.chance(0.03) ? size() : random_.chance(0.2) ? 1.0 : random_.unit());
    }
    double roughness() { return random_.chance(0.3) ? 0 : random_.chance(0.2) ? size() : random_.unit(); }

    void head() {
        text_ += "Film \"rgb\"" + whole("xresolution", 1 + random_.below(5)) +
                 whole("yresolution", 1 + random_.below(4)) + "\n";
        const double radius = random_.chance(0.8) ? random_.between(0.5, 3) : size();
        text_ += std::string("PixelFilter \"") + one_of(std::array{"box", "triangle", "gaussian", "mitchell", "sinc"}) +
                 "\"" + real("xradius", std::min(radius, 9.0)) + real("yradius", std::min(radius, 9.0)) + "\n";
        text_ += std::string("Sampler \"") + one_of(std::array{"independent", "zsobol", "halton"}) + "\"" +
                 whole("pixelsamples", 1 + random_.below(3)) + "\n";
        const char* integrator = one_of(std::array{"path", "path", "volpath", "lighttracer", "pssmlt"});
        text_ += std::string("Integrator \"") + integrator + "\"" +
                 whole("maxdepth", random_.below(random_.chance(0.1) ? 60 : 7));
        if (integrator == std::string("pssmlt"))
            text_ += whole("chains", 1 + random_.below(9)) + whole("bootstrapsamples", 1 + random_.below(99));
        text_ += "\n";
        if (random_.chance(0.25)) {
            text_ += "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"" + rgb("sigma_a", strength()) +
                     rgb("sigma_s", strength()) + real("g", random_.between(-1, 1)) +
                     (random_.chance(0.3) ? rgb("Le", strength()) : "") + "\n";
            has_media_ = true;
            if (random_.chance(0.4)) text_ += "MediumInterface \"\" \"fog\"\n";
        }
        if (random_.chance(0.1)) transform();
        text_ += "LookAt " + (random_.chance(0.7) ? std::string("0 0 -5 ") : point()) +
                 (random_.chance(0.8) ? std::string("0 0 0 ") : point()) + " 0 1 0\n";
        const double fov = random_.chance(0.8)   ? random_.between(20, 100)
                           : random_.chance(0.5) ? 179.99999
                                                 : 1e-5 * random_.unit();
        text_ += "Camera \"perspective\"" + real("fov", fov);
        if (random_.chance(0.2)) text_ += real("lensradius", strength()) + real("focaldistance", size());
        if (random_.chance(0.05))
            text_ += " \"float screenwindow\" [" + number(signed_size()) + number(signed_size()) +
                     number(signed_size()) + number(signed_size()) + "]";
        text_ += "\n";
    }

    void transform() {
        switch (random_.below(6)) {
            case 0:
                text_ += "Translate " + point() + "\n";
                break;
            case 1:
                text_ += "Scale " + number(side() * size()) + number(side() * size()) +
                         number(random_.chance(0.02) ? 0 : size()) + "\n";
                break;
            case 2: {
                const std::string s = number(size());
                text_ += "Scale " + s + s + s + "\n";
                break;
            }
            case 3:
                text_ += "Rotate " + number(random_.between(-720, 720)) + point() + "\n";
                break;
            case 4:
                text_ += "ConcatTransform [" + matrix() + "]\n";
                break;
            default:
                text_ += "Translate " + number(random_.between(-2, 2)) + number(random_.between(-2, 2)) + "0\n";
        }
    }
    std::string matrix() {
        std::string text;
        for (int i = 0; i < 16; ++i)
            text += i % 4 == 3 ? (i == 15 ? number(1) : number(0))
                               : number(random_.chance(0.1) ? signed_size() : random_.between(-2, 2));
        return text;
    }

    void material() {
        const char* type = one_of(std::array{"diffuse", "diffuse", "conductor", "dielectric", "thindielectric",
                                             "coateddiffuse", "coatedconductor", "raylex:additive", "interface"});
        const std::string name = type;
        text_ += "Material \"" + name + "\"";
        if (name == "diffuse" || name == "coateddiffuse") text_ += reflectance("reflectance");
        if (name == "conductor" && random_.chance(0.5)) text_ += reflectance("reflectance");
        if (name == "conductor" || name == "dielectric" || name == "coateddiffuse")
            text_ += real("roughness", roughness());
        if (name == "dielectric" || name == "thindielectric")
            text_ += real("eta", random_.chance(0.8) ? random_.between(0.5, 3) : size());
        if (name.starts_with("coated")) {
            if (random_.chance(0.3)) text_ += real("thickness", size());
            if (random_.chance(0.3)) text_ += rgb("albedo", 1) + real("g", random_.between(-1, 1));
        }
        text_ += "\n";
    }

    void light() {
        switch (random_.below(3)) {
            case 0:
                text_ += "LightSource \"point\" " + rgb("I", strength()) + " \"point3 from\" [" + point() + "]\n";
                break;
            case 1:
                text_ += "LightSource \"spot\" " + rgb("I", strength()) + " \"point3 from\" [" + point() +
                         "] \"point3 to\" [" + point() + "]" + real("coneangle", random_.between(0, 180)) +
                         real("conedeltaangle", random_.between(0, 90)) + "\n";
                break;
            default:
                text_ += "LightSource \"distant\" " + rgb("L", strength()) + " \"point3 from\" [" + point() +
                         "] \"point3 to\" [" + point() + "]\n";
        }
    }

    void object() {
        text_ += "ObjectBegin \"it\"\n";
        material();
        shape();
        text_ += "ObjectEnd\n";
        for (std::size_t i = 1 + random_.below(2); i > 0; --i) {
            text_ += "AttributeBegin\n";
            for (std::size_t k = random_.below(3); k > 0; --k) transform();
            text_ += "ObjectInstance \"it\"\nAttributeEnd\n";
        }
    }

    void shape() {
        const std::string alpha =
            random_.chance(0.2) ? real("alpha", random_.chance(0.8) ? random_.unit() : signed_size()) : "";
        const double radius = size();
        switch (random_.below(5)) {
            case 0:
                text_ += "Shape \"sphere\"" + real("radius", radius) + alpha;
                if (random_.chance(0.3))
                    text_ += real("zmin", radius * random_.between(-2, 2)) +
                             real("zmax", radius * random_.between(-2, 2)) + real("phimax", random_.between(0, 400));
                break;
            case 1:
                text_ += "Shape \"disk\"" + real("radius", radius) + real("height", signed_size()) +
                         real("innerradius", random_.chance(0.3) ? radius * random_.between(0, 1.02) : 0) + alpha;
                break;
            case 2:
                text_ += "Shape \"cylinder\"" + real("radius", radius) + real("zmin", signed_size()) +
                         real("zmax", signed_size()) + alpha;
                break;
            default:
                mesh(alpha);
        }
        text_ += "\n";
    }

    void mesh(const std::string& alpha) {
        const bool patches = random_.chance(0.4);
        const std::size_t corners = patches ? 4 : 3, count = 1 + random_.below(6);
        const double spread = random_.chance(0.1) ? 0 : size();
        const std::array<double, 3> place = random_.chance(0.8)
                                                ? std::array<double, 3>{0, 0, 0}
                                                : std::array<double, 3>{signed_size(), signed_size(), signed_size()};
        std::string points, indices, normals;
        for (std::size_t i = 0; i < corners * count; ++i) {
            points += random_.chance(0.02) ? point() : near(place, spread);
            normals += random_.chance(0.1) ? "0 0 0 " : point();
            indices += std::to_string(random_.chance(0.9) ? i : random_.below(corners * count)) + " ";
        }
        text_ += std::string("Shape \"") + (patches ? "bilinearmesh" : "trianglemesh") + "\" \"integer indices\" [" +
                 indices + "] \"point3 P\" [" + points + "]" + alpha;
        if (random_.chance(0.3)) text_ += " \"normal N\" [" + normals + "]";
    }

    Random random_;
    std::string text_;
    bool has_media_ = false;
};

display::ChannelDefinition layer(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = display::ChannelStyle::expression;
    channel.expression = expression;
    return channel;
}

}  // namespace

std::string random_scene(std::uint64_t index) {
    return SceneWriter(index).write();
}

raylex::transport::RenderSettings random_settings(std::uint64_t index, std::size_t& partition) {
    Random random(index * 2);
    raylex::transport::RenderSettings settings;
    settings.threads = 1;
    settings.seed = index;
    settings.splat = random.chance(0.15);
    settings.picked_lobes = random.chance(0.1);
    static const std::array<std::vector<std::string>, 3> partitions{{
        {"C[LO]", "C.[LO]", "C..+[LO]"},
        {"C<RD>.*", "C<TD>.*", "C<R[GS]>.*", "C<T[GS]>.*", "CV.*", "C[LO]"},
        {"C.*B", "C.*O", "C.*<L.>-C.*B"},
    }};
    const std::vector<std::string>& chosen = partitions[random.below(partitions.size())];
    for (const std::string& expression : chosen)
        settings.channels.push_back(layer("layer" + std::to_string(settings.channels.size()), expression));
    partition = settings.channels.size();
    for (const char* aov : {"Nn", "z", "Pw", "curvature", "albedo", "sampleCount"}) {
        if (!random.chance(0.1)) continue;
        display::ChannelDefinition channel;
        channel.name = aov;
        channel.style = display::ChannelStyle::name;
        settings.channels.push_back(channel);
    }
    if (random.chance(0.05)) settings.channels.push_back(layer("open", "unoccluded;C<RD>L"));
    return settings;
}

}  // namespace soak_test
