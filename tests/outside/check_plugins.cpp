// Runs the installed program with the plugins of this project and looks at what each one did.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "check.h"
#include "display/output/reader/exr_reader.h"

int failures = 0;

void check(bool holds, const std::string& what) {
    std::printf("%s %s\n", holds ? "holds:" : "FAILS:", what.c_str());
    if (!holds) ++failures;
}

void write(const std::string& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

std::string read(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::string plugin(const std::string& name) {
    return "--plugin '" OUTSIDE_PLUGINS "/lib" + name + ".so' ";
}

int run(const std::string& arguments) {
    const int status = std::system(("'" OUTSIDE_RAYLEX "' " + arguments + " >out.txt 2>err.txt").c_str());
    return status < 0 ? -1 : status >> 8;
}

std::vector<float> read_layer(const std::string& layer) {
    const auto image = raylex::display::read_exr("out.exr");
    if (!image || image->layer(layer) == nullptr) {
        check(false, "layer '" + layer + "' of the image");
        return {};
    }
    return image->layer(layer)->triple()[0]->values;
}

std::vector<float> render(const std::string& arguments, const std::string& layer) {
    if (run("render " + arguments + " -o out.exr") == 0) return read_layer(layer);
    check(false, arguments + ": " + read("err.txt"));
    return {};
}

void write_scene(const std::string& integrator, const std::string& world) {
    write("scene.pbrt",
          "LookAt 0 0 4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 20\n"
          "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n"
          "PixelFilter \"box\"\nSampler \"zsobol\" \"integer pixelsamples\" 16\n" +
              integrator + "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n" + world);
}
const std::string wall =
    "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0] \"point2 uv\" [0 0 1 0 0 1 1 1]\n";

std::size_t pixel(int x, int y) {
    return static_cast<std::size_t>(16 * y + x);
}

namespace {

using namespace raylex;

/// The command is refused with exit code 2 and a message that contains the place and this text.
void check_refused(const std::string& arguments, const std::string& place, const std::string& message) {
    const bool refused = run(arguments) == 2;
    const std::string said = read("err.txt");
    check(refused && said.find(place) != std::string::npos && said.find(message) != std::string::npos,
          "refused at " + place + " with " + message + (refused ? "" : "; it was not: ") + (refused ? "" : said));
}

void check_integrator() {
    write_scene("Integrator \"ambientocclusion\" \"float maxdistance\" 1\n", wall);
    const std::vector<float> open = render(plugin("ambient_occlusion") + "scene.pbrt");
    check(open.size() == 256 && open[pixel(8, 8)] == 1, "ambientocclusion: a lone wall sees the whole sky");
    // Something 2 away from the wall: out of reach, then within.
    const std::string lid = wall + "Translate 0 0 2 Shape \"disk\" \"float radius\" 500 \"float innerradius\" 1.5\n";
    write_scene("Integrator \"ambientocclusion\" \"float maxdistance\" 1\n", lid);
    const std::vector<float> far = render(plugin("ambient_occlusion") + "scene.pbrt");
    write_scene("Integrator \"ambientocclusion\" \"float maxdistance\" 1000\n", lid);
    const std::vector<float> near =
        render(plugin("ambient_occlusion") + "scene.pbrt --spp 1024 --lpe diffuse='C<RD>L'");
    // The hole of radius 1.5 at height 2: sin^2 of its half angle, 0.36, is what a point below its centre sees. The
    // standard error of 1024 random samples is 0.015; the sampler is better.
    check(far.size() == 256 && far[pixel(8, 8)] == 1, "ambientocclusion: maxdistance bounds what hides the sky");
    check(near.size() == 256 && std::abs(near[pixel(8, 8)] - 0.36f) < 0.02f,
          "ambientocclusion: a lid with a hole leaves 0.36");
    const std::vector<float> layer =
        render(plugin("ambient_occlusion") + "scene.pbrt --spp 16 --lpe diffuse='C<RD>L'", "diffuse");
    const std::vector<float> beauty = render(plugin("ambient_occlusion") + "scene.pbrt --spp 16");
    check(!layer.empty() && layer == beauty, "ambientocclusion: light path expressions work without a word about them");
    write_scene("Integrator \"ambientocclusion\" \"float maxdistance\" -3\n", wall);
    check_refused("render " + plugin("ambient_occlusion") + "scene.pbrt -o out.exr",
                  "scene.pbrt:6:", "'maxdistance' is -3; expected");
}

void check_pattern() {
    const auto textured = [](const std::string& texture) {
        write_scene("", "Texture \"t\" \"spectrum\" " + texture +
                            "\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n" + wall);
    };
    textured("\"constant\" \"rgb value\" [.25 .25 .25]");
    const std::vector<float> quarter = render("scene.pbrt --max-depth 1");
    textured("\"stripes\" \"rgb tex1\" [.25 .25 .25] \"rgb tex2\" [.25 .25 .25]");
    check(render(plugin("stripes") + "scene.pbrt --max-depth 1") == quarter,
          "stripes of one colour are that colour, bit by bit");
    // Two stripes over the wall, which is 2 wide at distance 4, the image 1.41 wide there. Seen from the front, +x is
    // left.
    textured("\"stripes\" \"integer count\" 1 \"rgb tex1\" [.25 .25 .25] \"rgb tex2\" [.75 .75 .75]");
    const std::vector<float> two = render(plugin("stripes") + "scene.pbrt --max-depth 1");
    check(two.size() == 256 && two[pixel(13, 8)] == quarter[pixel(13, 8)] && std::abs(two[pixel(2, 8)] - 0.75f) < 1e-5f,
          "stripes: 0.75 on the left, 0.25 on the right under a sky of 1");
    textured("\"stripes\" \"integer count\" 0");
    check_refused("render " + plugin("stripes") + "scene.pbrt -o out.exr",
                  "scene.pbrt:8:", "'count' is 0; expected 1 to 10000");
    check_refused("render scene.pbrt -o out.exr", "scene.pbrt:8:", "unknown texture 'stripes'");  // without the plugin
}

void check_material() {
    write_scene("",
                "MakeNamedMaterial \"moon\" \"string type\" \"minnaert\" \"rgb reflectance\" [.5 .5 .5] \"float k\" 1\n"
                "NamedMaterial \"moon\"\n" +
                    wall);
    const std::string with = plugin("minnaert") + "scene.pbrt --max-depth 1 ";
    const std::vector<float> seen = render(with);
    // Under a sky of 1 a surface has its albedo for radiance, 0.5 cos; the centre is seen at less than 1 degree (cos
    // above 0.9998), and its samples have no variance.
    check(seen.size() == 256 && std::abs(seen[pixel(8, 8)] - 0.5f) < 2e-4f, "minnaert: its albedo under a white sky");
    check(render(with + "--dialect osl --lpe moon=\"C<RD'moon''minnaert'>B\"", "moon") == seen,
          "minnaert: light path expressions know its lobe");
    write_scene("", "LightSource \"point\" \"point3 from\" [0 0 3]\nMaterial \"minnaert\" \"float k\" 2\n" + wall);
    const std::vector<float> lit = render(plugin("minnaert") + "scene.pbrt --partition shipped");
    check(lit.size() == 256 && run("verify out.exr") == 0, "minnaert: splits sum to beauty with light samples");
    write_scene("", "Material \"minnaert\" \"float k\" -1\n" + wall);
    check_refused("render " + plugin("minnaert") + "scene.pbrt -o out.exr",
                  "scene.pbrt:8:", "'k' is -1; expected 0 to 100");
}

void check_camera() {
    const std::string seen =
        "LookAt 0 0 4  0 0 0  0 1 0\nCamera \"parallel\" \"float extent\" 2\n"
        "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\nPixelFilter \"box\"\n"
        "Sampler \"zsobol\" \"integer pixelsamples\" 256\nWorldBegin\n";
    const std::string with = plugin("orthographic_camera") + "scene.pbrt --max-depth 1 ";
    write("scene.pbrt", seen + "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\"\n" + wall);
    const std::vector<float> sky = render(with);
    // The wall is 2 wide and the image 4: 8 of 16 pixels, at any distance. Under a sky of 1 it has its albedo, 0.5.
    check(sky.size() == 256 && std::abs(sky[pixel(4, 8)] - 0.5f) < 1e-4f &&
              std::abs(sky[pixel(11, 11)] - 0.5f) < 1e-4f && sky[pixel(3, 8)] == 1 && sky[pixel(12, 8)] == 1,
          "orthographic: the wall is as large as it is, whatever its distance");
    write("scene.pbrt", seen + "LightSource \"point\" \"point3 from\" [0.3 0.2 1.5]\nMaterial \"diffuse\"\n" + wall);
    const std::vector<float> paths = render(with), light = render(with + "--integrator lighttracer --spp 4096");
    double from_camera = 0, from_light = 0;
    for (const float each : paths) from_camera += static_cast<double>(each);
    for (const float each : light) from_light += static_cast<double>(each);
    check(from_camera > 1 && std::abs(from_light / from_camera - 1) < 0.01,
          "orthographic: light paths that meet it bring what its own rays find");
    write("scene.pbrt", "Camera \"parallel\" \"float extent\" -2\nWorldBegin\n" + wall);
    check_refused("render " + plugin("orthographic_camera") + "scene.pbrt -o out.exr",
                  "scene.pbrt:1:", "'extent' is -2; expected a positive length");
    // Without the plugin.
    check_refused("render scene.pbrt -o out.exr", "scene.pbrt:1:", "unknown camera 'parallel'");
}

void check_shape() {
    // Sky of 1 where the shape is not, half of it where it is: a triangle of radius 0.5 around the centre, its tip to
    // the right; the image is 1.41 wide there. Seen from the front, +x is left.
    write_scene("",
                "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n"
                "Rotate 180 0 0 1 Shape \"polygon\" \"integer sides\" 3 \"float radius\" .5\n");
    const std::vector<float> seen = render(plugin("polygon_shape") + "scene.pbrt --max-depth 1");
    check(seen.size() == 256 && std::abs(seen[pixel(8, 8)] - 0.5f) < 1e-5f && seen[pixel(4, 8)] == 1 &&
              seen[pixel(14, 8)] == 1 && std::abs(seen[pixel(10, 8)] - 0.5f) < 1e-5f,
          "polygon: a triangle with its tip to the right, placed by the current transformation");
    write_scene("", "Shape \"polygon\" \"integer sides\" 2\n");
    check_refused("render " + plugin("polygon_shape") + "scene.pbrt -o out.exr",
                  "scene.pbrt:8:", "'sides' is 2; expected");
    write_scene("", "Shape \"polygon\" \"integer side\" 4\n");
    check_refused("render " + plugin("polygon_shape") + "scene.pbrt -o out.exr",
                  "scene.pbrt:8:", "shape 'polygon' has no parameter 'side'; expected one of: sides, radius, alpha");
    check_refused("render scene.pbrt -o out.exr", "scene.pbrt:8:", "unknown shape 'polygon'");  // without the plugin
}

void check_display_filter() {
    write_scene("", "Material \"diffuse\"\n" + wall);
    const std::vector<float> plain = render("scene.pbrt --statistics beauty=mse"), error = read_layer("beauty_mse");
    const std::vector<float> dark =
        render(plugin("vignette_filter") +
               "scene.pbrt --statistics beauty=mse --partition shipped --display-filter vignette:strength=0.5");
    // Half of the squared distance to the corner is lost: at pixel (13, 8), 5.5^2 + 0.5^2 of 8^2 + 8^2. One rounding to
    // float on either side of the factor.
    const float factor = 1 - 0.5f * 30.5f / 128;
    bool right = plain.size() == 256 && dark.size() == 256;
    for (const auto& [x, y] : {std::pair(13, 8), std::pair(2, 8), std::pair(8, 13), std::pair(7, 2)})
        right = right && std::abs(dark[pixel(x, y)] - factor * plain[pixel(x, y)]) <= 0x1p-22f * plain[pixel(x, y)];
    check(right, "vignette: light falls off with the squared distance from the middle");
    check(run("verify out.exr") == 0, "vignette: splits still sum to beauty");
    check(!error.empty() && read_layer("beauty_mse") == error, "vignette: statistics never see a display filter");
    check_refused("render " + plugin("vignette_filter") + "scene.pbrt -o out.exr --display-filter vignette:strength=2",
                  "--display-filter", "'strength' is 2; expected 0 to 1");
    check_refused("render scene.pbrt -o out.exr --display-filter vignette", "--display-filter",
                  "unknown display filter 'vignette'");
}

void check_filter_and_driver() {
    write_scene("", "Material \"diffuse\"\n" + wall);
    write("job.toml", "plugins = ['" OUTSIDE_PLUGINS
                      "/libexposure.so']\n[scene]\nfile = \"scene.pbrt\"\n"
                      "[channels]\nshipped_partition = true\n[[sample_filter]]\ntype = \"exposure\"\nstops = 1.0\n");
    const std::vector<float> plain = render("scene.pbrt");
    std::vector<float> doubled = plain;
    for (float& value : doubled) value *= 2;
    const std::vector<float> exposed = render(plugin("pfm") + "job.toml --driver pfm:file=out.pfm");
    check(!plain.empty() && exposed == doubled, "exposure: one stop doubles every pixel, bit by bit");
    check(run("verify out.exr") == 0, "exposure: splits still sum to beauty");
    const std::string pfm = read("out.pfm"), header = "PF\n16 16\n-1.0\n";
    bool same = pfm.size() == header.size() + 256 * 12 && pfm.starts_with(header) && exposed.size() == 256;
    for (int y = 0; same && y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            float value;
            std::copy_n(pfm.data() + header.size() + 12 * pixel(x, 15 - y), sizeof value,
                        reinterpret_cast<char*>(&value));
            same = same && value == exposed[pixel(x, y)];
        }
    check(same, "pfm: the file holds the pixels of the OpenEXR file");
    check_refused("render " + plugin("pfm") + "scene.pbrt -o out.exr --driver pfm:file=out.pfm,laier=Nn", "--driver",
                  "did you mean 'layer'?");
    check_refused("render " + plugin("pfm") + "scene.pbrt -o out.exr --driver pfm:file=out.pfm,layer=Nm --aov Nn",
                  "--driver", "did you mean 'Nn'?");
    std::string job = read("job.toml");
    write("job.toml", job.replace(job.find("stops = 1.0"), 11, "stops = 99"));
    check_refused("render job.toml -o out.exr", "job.toml:8:", "'stops' is 99; expected -20 to 20");
}

void check_listing() {
    const bool listed = run("plugins '" OUTSIDE_PLUGINS "/libminnaert.so'") == 0;
    check(listed && read("out.txt").find("material minnaert: the moon's surface") != std::string::npos &&
              read("out.txt").find("float k = 0.5:") != std::string::npos,
          "`raylex plugins` lists what a plugin registered, with its parameters");
}

}  // namespace

int main() {
    check_integrator();
    check_pattern();
    check_material();
    check_camera();
    check_shape();
    check_filter_and_driver();
    check_display_filter();
    check_listing();
    check_promises();
    return failures == 0 ? 0 : 1;
}
