#include "tests/soak/readers.h"

#include <zlib.h>

#include <array>

#include <ImfThreading.h>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/checkpoint/record_file.h"
#include "display/output/atlas/atlas_file.h"
#include "display/output/color/color_manager.h"
#include "display/output/reader/exr_reader.h"
#include "experiments/job/channels/channel_set.h"
#include "experiments/job/job_file.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/results_file.h"
#include "lpe/adopt/program_file.h"
#include "lpe/program.h"
#include "lpe/vectors.h"
#include "tests/display/files.h"
#include "tests/display/made_atlas.h"
#include "tests/support/folder.h"
#include "transport/color/spectrum.h"
#include "transport/files/images/image.h"
#include "transport/files/ply.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/materials/material.h"
#include "transport/textures/texture.h"

namespace raylex::test {

namespace {

const std::string scene = R"(Film "rgb" "integer xresolution" 16 "integer yresolution" 16
LookAt 0 1 4  0 1 0  0 1 0
Camera "perspective" "float fov" 50
Include "part.pbrt"
WorldBegin
Attribute "shape" "float alpha" 0.5
Texture "picture" "spectrum" "imagemap" "string filename" "picture.pfm"
Texture "weaker" "spectrum" "scale" "texture tex" "picture" "float scale" 0.5
Texture "board" "spectrum" "checkerboard" "texture tex1" "weaker" "rgb tex2" [.1 .2 .3]
MakeNamedMaterial "paint" "string type" "diffuse" "texture reflectance" "board"
MakeNamedMaterial "metal" "string type" "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" [400 3 700 4]
MakeNamedMaterial "both" "string type" "mix" "string materials" ["paint" "metal"] "float amount" 0.25
LightSource "point" "rgb I" [3 3 3] "point3 from" [0 2 1]
AttributeBegin
AreaLightSource "diffuse" "blackbody L" 6500 "float scale" 2
NamedMaterial "both" Rotate 30 0 1 0
Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [-1 0 1 1 0 1 1 0 -1] "normal N" [0 1 0 0 1 0 0 nan 0]
AttributeEnd
ObjectBegin "o" Shape "plymesh" "string filename" "mesh.ply" Shape "sphere" "float radius" 2 ObjectEnd
ObjectInstance "o"
)";

const std::string mesh =
    "ply\nformat ascii 1.0\ncomment small\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property float nx\nproperty float ny\nproperty float nz\nelement face 2\nproperty list uchar int vertex_indices\n"
    "end_header\n0 0 0 0 0 1\n1 0 0 0 0 nan\n1 1 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n4 0 1 2 3\n";

const std::string job = R"([scene]
file = "scene.pbrt"
[render]
spp = 4
seed = 7
[integrator]
type = "path"
maxdepth = 3
[channels]
aovs = ["Nn", "z"]
shipped_partition = true
[[channel]]
name = "floor.light"
lpe = "C<RD'paint'>S+<L.'key'>"
[[label]]
material = "paint"
label = "floor"
[[light_group]]
light = "point:0"
group = "key"
)";

const std::string study = R"toml(replicates = 2
[[scene]]
name = "one"
file = "scene.pbrt"
[[method]]
name = "path"
[[method]]
name = "other"
command = "other --seed {seed} --spp {spp} --outfile {out} {scene}"
[sweep]
max_depth = [2, 4, 8]
[budget]
samples = "pow2(0..4)"
seconds = 10
[reference]
method = "path"
error = "0.2%"
[[channel]]
name = "direct"
lpe = "C<RD>L"
)toml";

const std::string rib = R"(DisplayChannel "color Ci"
DisplayChannel "color direct" "string source" "color lpe:C<RD>[<L.>O]"
DisplayChannel "color indirect" "string source" ["color lpe:C<RD>[DSV]+[<L.>O]"]
)";
const std::string usda = R"(#usda 1.0
def Scope "Render"
{
    def RenderVar "direct"
    {
        token dataType = "color3f"
        string sourceName = "C<RD>L"
        token sourceType = "lpe"
    }
}
)";
const std::string ini = "/prman/lpe/diffuse2 Diffuse,HairDiffuse\n/prman/lpe/directdiffuse C<RD>[<L.>O]\n";
const std::string channel_toml =
    "[[channel]]\nname = \"a\"\nlpe = \"C<RD>L\"\n[[partition]]\nname = \"p\"\nchannels = [\"a\"]\n";
const std::string vectors = "C<RD>L\tC,- R,D L,-\t1\nC<RS'a*b'>L\tC,- R,S,ab L,-\t1\n";
const std::string spectrum_numbers = "# nm value\n400 0.5\n550.5 +1e-1\n700 2\n";
std::string packed(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    std::string result(deflateBound(&stream, bytes.size()) + 32, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(result.size());
    deflate(&stream, Z_FINISH);
    result.resize(stream.total_out);
    deflateEnd(&stream);
    return result;
}

template <class T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The same triangle as little-endian data.
std::string binary_mesh() {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\n"
        "property short z\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n";
    for (int i = 0; i < 3; ++i) {
        put(bytes, static_cast<float>(i));
        put(bytes, static_cast<double>(i * i));
        put(bytes, static_cast<short>(i));
    }
    put(bytes, static_cast<unsigned char>(3));
    for (const unsigned corner : {0U, 1U, 2U}) put(bytes, corner);
    return bytes;
}

std::string float_map() {
    std::string bytes = "PF\n4 3\n-1.0\n";
    for (int i = 0; i < 36; ++i) put(bytes, static_cast<float>(i) / 36);
    return bytes;
}

std::string targa(bool packets) {
    const std::array<unsigned char, 18> header{
        0, 0, static_cast<unsigned char>(packets ? 10 : 2), 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 2, 0, 24, 0x20};
    std::string bytes(header.begin(), header.end());
    if (packets) {
        for (int row = 0; row < 2; ++row) bytes += std::string("\x83\x10\x20\x30", 4);
    } else {
        for (int i = 0; i < 24; ++i) bytes += static_cast<char>(10 * i);
    }
    return bytes;
}

std::string radiance_map() {
    std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n";
    for (int row = 0; row < 2; ++row) {
        bytes += std::string("\x02\x02\x00\x08", 4);
        for (int plane = 0; plane < 4; ++plane) bytes += std::string("\x88\x80", 2);
    }
    return bytes;
}

std::string portable_network_graphic(const std::string& folder) {
    std::vector<unsigned char> rgb;
    for (int i = 0; i < 8 * 6 * 3; ++i) rgb.push_back(static_cast<unsigned char>(7 * i));
    const std::string path = folder + "/seed.png";
    if (!display::write_png(path, 8, 6, rgb)) return {};
    return read_bytes(path);
}

std::vector<std::string> open_exr(const std::string& folder) {
    const auto plane = [](const char* name, Imf::PixelType type) {
        return ForeignChannel{name, type, std::vector<float>(48, 0.25f)};
    };
    const std::vector<ForeignChannel> colors{plane("R", Imf::HALF), plane("G", Imf::HALF), plane("B", Imf::HALF)};
    const std::vector<ForeignChannel> layers{plane("R", Imf::FLOAT), plane("G", Imf::FLOAT), plane("B", Imf::FLOAT),
                                             plane("a.Z", Imf::FLOAT), plane("id", Imf::UINT)};
    std::vector<std::string> seeds;
    const std::string path = folder + "/seed.exr";
    write_foreign(path, colors, box(8, 6), box(8, 6));
    seeds.push_back(read_bytes(path));
    write_foreign(path, layers, box(10, 8), box(8, 6), 4);
    seeds.push_back(read_bytes(path));
    return seeds;
}

std::string checkpoint(const std::string& folder) {
    display::RecordFile record;
    record.identity = {{"scene", "a.pbrt"}, {"seed", "3"}};
    record.sections = {{"position", std::string(40, '\3')}, {"frame buffer", std::string(200, '\1')}};
    const std::string path = folder + "/seed.record";
    if (!display::write_record_file(path, record, display::FileSync::later)) return {};
    return read_bytes(path);
}

std::vector<std::string> path_atlas(const std::string& folder) {
    std::vector<std::string> seeds;
    for (const display::SignedLight negative : {display::SignedLight::none, display::SignedLight::light}) {
        MadeAtlas made(negative);
        const std::string path = folder + "/seed.atlas.exr";
        if (!display::write_atlas(path, made, {})) return {};
        seeds.push_back(read_bytes(path));
    }
    Imf::setGlobalThreadCount(0);  // writing may have begun some, and children that are forked have none of them
    return seeds;
}

std::string run(const std::string& folder) {
    experiments::StudyRun run;
    run.id = "a.path.1spp.r0";
    run.scene = "a";
    run.method = "path";
    run.warnings = {"none"};
    const std::string path = folder + "/seed.json";
    if (!experiments::write_run_file(path, run, display::FileSync::later)) return {};
    return read_bytes(path);
}

std::string compiled_program() {
    lpe::ChannelSource source;
    source.name = "direct";
    source.expression = "C<RD'a*'>L";
    const auto program = lpe::Program::compile({&source, 1}, {});
    return program ? lpe::to_bytes(*program) : std::string();
}

bool read_scene(const std::string& path) {
    const auto read = transport::import_pbrt(path);
    if (!read) return false;
    auto textures = transport::TextureTable::build(*read);
    return textures && transport::MaterialTable::build(*read, *textures).ok();
}

bool read_spectrum(const std::string& path) {
    Parameter parameter;
    parameter.name = "L";
    parameter.type = ParameterType::spectrum;
    parameter.strings = {path};
    return transport::resolve_spectrum(parameter, transport::SpectrumRole::unbounded, {}).ok();
}

bool read_channels(const std::string& path) {
    const auto set = experiments::read_channel_files({path}, "", lpe::Dialect::renderman);
    std::vector<std::string> warnings;
    return set && experiments::expanded_channels(*set, warnings).ok();
}

bool read_record(const std::string& path) {
    const auto record = display::read_record_file(path);
    if (!record) return false;
    for (const display::RecordSection& section : record->sections)
        static_cast<void>(display::FrameBuffer::from_record(section.content));
    return true;
}

bool read_atlas(const std::string& path) {
    const auto atlas = display::AtlasFile::open(path);
    if (!atlas) return false;
    bool good = true;
    display::AtlasRow row;
    for (int y = 0; y < (*atlas)->height(); ++y) good = (*atlas)->row(y, row).ok() && good;
    return good && display::check_atlas(**atlas).ok();
}

bool read_image(const std::string& path) {
    return transport::read_image(path).ok();
}
bool read_study(const std::string& path) {
    return experiments::read_experiment_config(path, {}).ok();
}
bool read_vectors(const std::string& path) {
    return lpe::run_vectors(path, lpe::Dialect::renderman).ok();
}

template <auto Read>
bool read_with(const std::string& path) {
    return Read(path).ok();
}

}  // namespace

std::vector<InputKind> input_kinds(const std::string& folder) {
    write_bytes(folder + "/part.pbrt", "Sampler \"independent\" \"integer pixelsamples\" 4\n");
    write_bytes(folder + "/picture.pfm", float_map());
    write_bytes(folder + "/mesh.ply", mesh);
    write_bytes(folder + "/scene.pbrt", scene);
    return {
        {"scene", ".pbrt", {scene, packed(scene)}, read_scene},
        {"mesh", ".ply", {mesh, binary_mesh(), packed(mesh)}, read_with<transport::read_ply>},
        {"png", ".png", {portable_network_graphic(folder)}, read_image},
        {"tga", ".tga", {targa(false), targa(true)}, read_image},
        {"hdr", ".hdr", {radiance_map()}, read_image},
        {"pfm", ".pfm", {float_map()}, read_image},
        {"exr texture", ".exr", open_exr(folder), read_image},
        {"exr", ".exr", open_exr(folder), read_with<display::read_exr>},
        {"atlas", ".exr", path_atlas(folder), read_atlas},
        {"job", ".toml", {job}, read_with<experiments::read_job>},
        {"study", ".toml", {study}, read_study},
        {"rib", ".rib", {rib}, read_channels},
        {"usda", ".usda", {usda}, read_channels},
        {"ini", ".ini", {ini}, read_channels},
        {"channels", ".toml", {channel_toml}, read_channels},
        {"vectors", ".tsv", {vectors}, read_vectors},
        {"spectrum", ".spd", {spectrum_numbers}, read_spectrum},
        {"checkpoint", ".checkpoint", {checkpoint(folder)}, read_record},
        {"program", ".lpe", {compiled_program()}, read_with<lpe::load>},
        {"cell", ".json", {run(folder)}, read_with<experiments::read_run_file>},
    };
}

}  // namespace raylex::test
