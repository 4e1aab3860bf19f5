// The counts of `raylex scene info`, and the warnings of `raylex scene check`.
#include <catch2/catch.hpp>

#include "experiments/job/text/json.h"
#include "support.h"

using namespace raylex;
using namespace raylex::test;

namespace {

const char* const counted_scene = R"(Film "rgb" "integer xresolution" 8 "integer yresolution" 4
Camera "perspective"
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
MakeNamedMaterial "wood" "string type" "diffuse"
NamedMaterial "wood"
AttributeBegin
AreaLightSource "diffuse" "rgb L" [2 2 2]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 4  1 2 4  1 2 6  -1 2 6]
AttributeEnd
ObjectBegin "leaf"
Shape "sphere" "float radius" 0.1
Shape "disk"
ObjectEnd
AttributeBegin
Translate 3 0 5
ObjectInstance "leaf"
AttributeEnd
AttributeBegin
Translate -3 0 5
ObjectInstance "leaf"
AttributeEnd
)";

}  // namespace

TEST_CASE("raylex scene info counts the contents of a scene and prints its bounds") {
    const Folder folder;
    folder.write("room.pbrt", counted_scene);
    const Outcome outcome = run_raylex(folder, "scene info room.pbrt --json facts.json --picture room.png");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "1 trianglemesh, 1 sphere, 1 disk"));
    CHECK(contains(outcome.out, "2 triangle, 2 quadric; rays meet 6"));
    CHECK(contains(outcome.out, "2 instances of 1 object"));
    CHECK(contains(outcome.out, "(-4, -1, 4) to (4, 2, 6)"));
    CHECK(contains(outcome.out, "effects: "));
    const experiments::Json facts = experiments::parse_json(folder.read("facts.json"));
    CHECK(facts["primitives_rendered"] == 6);
    CHECK(facts["emitters"] == 3);  // two triangles and the sky
    CHECK(facts["lights"]["infinite"] == 1);
    CHECK(facts["lights"]["area"] == 1);
    CHECK(facts["labels"][0] == "wood");
    CHECK(facts["film"]["width"] == 8);
    CHECK(facts["bounds"]["upper"][0] == 4);
    CHECK(facts["peak_bytes"] > 1000000);
    CHECK(facts["effects"]["instances"]["called_for"] == true);
    CHECK(folder.read("room.png").substr(1, 3) == "PNG");

    const Outcome unbuilt = run_raylex(folder, "scene info room.pbrt --no-build");
    CHECK(unbuilt.code == 0);
    CHECK_FALSE(contains(unbuilt.out, "bounds"));
    CHECK(run_raylex(folder, "scene info nowhere.pbrt").code == 2);
    CHECK(facts["materials"] == experiments::Json{{"diffuse", 1}});  // the default material is unused
    CHECK(contains(run_raylex(folder, "scene info room.pbrt --picture room.jpg").err, "expected a PNG file name"));
}

TEST_CASE("raylex scene info lists media by name") {
    const Folder folder;
    folder.write("media.pbrt",
                 "MakeNamedMedium \"smoke\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1]\n"
                 "MakeNamedMedium \"ink\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0]\n"
                 "MakeNamedMedium \"fire\" \"string type\" \"uniformgrid\" \"integer nx\" 1 \"integer ny\" 1 "
                 "\"integer nz\" 1 \"float density\" [1] \"rgb sigma_s\" [1 1 1] \"rgb Le\" [1 1 1]\n"
                 "MakeNamedMedium \"unused\" \"string type\" \"homogeneous\"\n"
                 "WorldBegin\nMaterial \"interface\"\n"
                 "MediumInterface \"smoke\" \"\" Shape \"sphere\"\nTranslate 4 0 0\n"
                 "MediumInterface \"ink\" \"\" Shape \"sphere\"\nTranslate 4 0 0\n"
                 "MediumInterface \"fire\" \"\" Shape \"sphere\"\nTranslate 4 0 0\n"
                 "Material \"subsurface\" MediumInterface \"\" \"\" Shape \"sphere\"\n");
    const Outcome outcome = run_raylex(folder, "scene info media.pbrt --json facts.json");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "medium names  smoke (scatters), ink (absorbs), fire (scatters, emits)\n"));
    CHECK(experiments::parse_json(folder.read("facts.json"))["media_by_name"]["fire"]["emits"] == true);
}

TEST_CASE("raylex scene check finds likely mistakes with their lines, and exits with 1") {
    const Folder folder;
    const auto check = [&](const std::string& world, const std::string& warning) {
        folder.write("doubtful.pbrt", "Camera \"perspective\"\nWorldBegin\n" + world);
        const Outcome outcome = run_raylex(folder, "scene check doubtful.pbrt");
        CAPTURE(world, outcome.out, outcome.err);
        CHECK(outcome.code == (warning.empty() ? 0 : 1));
        CHECK(contains(outcome.out, warning.empty() ? "0 likely mistakes" : warning));
    };
    const std::string sky = "LightSource \"infinite\"\n";
    const std::string face = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 5  1 0 5  0 1 5] ";
    check(sky + face + "\n", "");
    check(face + "\n", "doubtful.pbrt: the scene has no light: its image is black");
    check(sky + face + "\"normal N\" [0 0 1  0 0 -1  0 0 1]\n",
          "doubtful.pbrt:4:1: 1 of 1 faces of the mesh have vertex normals on both sides");
    check(sky + "Texture \"a\" \"spectrum\" \"checkerboard\"\nMaterial \"diffuse\" \"texture reflectance\" \"a\"\n" +
              face + "\"point2 uv\" [0 0  1 1  2 2]\n",
          "have collinear texture coordinates");
    check(sky + face + "\nLightSource \"point\" \"rgb I\" [0 0 0]\n",
          "doubtful.pbrt:5:1: this point light emits no light");
    check(sky + "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [0 0 0]\n" + face + "\nAttributeEnd\n",
          "doubtful.pbrt:5:1: this area light emits no light");
    check(sky + face + "\nMakeNamedMaterial \"gold\" \"string type\" \"conductor\"\n",
          "doubtful.pbrt:5:1: the material 'gold' is unused");
    check(sky +
              "Texture \"wodo\" \"spectrum\" \"checkerboard\"\nTexture \"wood\" \"spectrum\" \"checkerboard\"\n"
              "Material \"diffuse\" \"texture reflectance\" \"wood\"\n" +
              face + "\n",
          "'wood' is used; did you mean this?");
    for (const char* other : {"wood1", "oak wood"}) {  // one of a series, and another word: not misspelt
        check(sky + "Texture \"" + other +
                  "\" \"spectrum\" \"checkerboard\"\nTexture \"wood2\" \"spectrum\" \"checkerboard\"\n"
                  "Material \"diffuse\" \"texture reflectance\" \"wood2\"\n" +
                  face + "\n",
              "is unused");
        CHECK_FALSE(contains(run_raylex(folder, "scene check doubtful.pbrt").out, "did you mean this"));
    }
    check(sky + face + "\nObjectBegin \"leaf\"\nShape \"sphere\"\nObjectEnd\n", "the object 'leaf' has no instance");

    // Media may be the only emitters.
    check(
        "MakeNamedMedium \"fire\" \"string type\" \"homogeneous\" \"rgb Le\" [1 1 1]\nMediumInterface \"fire\" \"\"\n" +
            face,
        "");
    // A box whose faces point inwards: by winding, by normals, reversed back, and as a hole in another one.
    const std::string box =
        "Shape \"trianglemesh\" \"point3 P\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1] ";
    const std::string inwards =
        "\"integer indices\" [0 1 2 1 3 2 4 6 5 5 6 7 0 4 1 1 4 5 2 3 6 3 7 6 0 2 4 2 6 4 1 5 3 3 5 7]\n";
    const std::string outwards =
        "\"integer indices\" [0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5]\n";
    const std::string normals = "\"normal N\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1] ";
    const std::string wax = sky + "Material \"subsurface\"\n", turned = " is closed and faces inwards";
    check(wax + box + inwards, turned);
    check(wax + box + outwards, "");
    check(wax + "ReverseOrientation\n" + box + inwards, "");
    check(wax + "ReverseOrientation\n" + box + outwards, turned);
    check(wax + "Scale -1 1 1\n" + box + inwards, turned);
    check(wax + box + normals + inwards, "");
    check(wax + box + inwards + "Scale 2 2 2\n" + box + outwards, "");
    check(wax + box + "\"integer indices\" [0 1 2 1 3 2 4 6 5]\n", "");  // open
    check(
        sky + "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"fog\" \"\"\n" + box + inwards,
        turned);
    // A room with fog in it, and the hole in a ball: behind those faces is no medium, or another body.
    check(
        sky + "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"fog\"\n" + box + inwards,
        "");
    check(wax + box + inwards + "Shape \"sphere\" \"float radius\" 4\n", "");
    // Warnings of the build are printed and counted.
    folder.write("dropped.pbrt", "Camera \"perspective\"\nWorldBegin\n" + sky +
                                     "Shape \"curve\" \"point3 P\" [0 0 5 0 0 5 0 0 5 0 0 5]\n" + face + "\n");
    const Outcome dropped = run_raylex(folder, "scene check dropped.pbrt");
    CHECK(dropped.code == 0);
    CHECK(contains(dropped.out, "1 warning, 0 likely mistakes"));
    CHECK(contains(dropped.err, "dropped.pbrt:4:1: 1 segments of curves have no length or no width"));
    // A short name is not a misspelling of an unknown one.
    check(sky + face + "\nTexture \"a\" \"float\" \"constant\"\n", "the texture 'a' is unused");
    CHECK_FALSE(contains(run_raylex(folder, "scene check doubtful.pbrt").out, "did you mean this"));
}

TEST_CASE("raylex scene check checks texture coordinates where something uses them, in mixes and patches too") {
    const Folder folder;
    const auto warnings = [&](const std::string& textures, const std::string& material, bool patch) {
        folder.write("uv.pbrt",
                     "WorldBegin\nLightSource \"infinite\"\n" + textures + "\n" + material + "\nShape " +
                         (patch ? "\"bilinearmesh\" \"point3 P\" [0 0 5  1 0 5  0 1 5  1 1 5]"
                                  " \"point2 uv\" [0 0  1 1  2 2  3 3]\n"
                                : "\"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 5  1 0 5  0 1 5]"
                                  " \"point2 uv\" [0 0  1 1  2 2]\n"));
        const Outcome outcome = run_raylex(folder, "scene check uv.pbrt");
        CAPTURE(textures, material, outcome.out, outcome.err);
        CHECK(outcome.code == (contains(outcome.out, "have collinear texture coordinates") ? 1 : 0));
        return outcome.code == 1;
    };
    const std::string by_a = "Material \"diffuse\" \"texture reflectance\" \"a\"";
    const std::string checks = "Texture \"a\" \"spectrum\" \"checkerboard\" ";
    CHECK(warnings(checks, by_a, false));
    CHECK(warnings(checks, by_a, true));
    CHECK_FALSE(warnings(checks + "\"string mapping\" \"planar\"", by_a, false));
    CHECK_FALSE(warnings("Texture \"a\" \"spectrum\" \"marble\"", by_a, false));
    CHECK(
        warnings("Texture \"b\" \"spectrum\" \"checkerboard\"\n"
                 "Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"float scale\" .5",
                 by_a, false));
    CHECK(warnings(checks,
                   "MakeNamedMaterial \"x\" \"string type\" \"diffuse\" \"texture reflectance\" \"a\"\n"
                   "MakeNamedMaterial \"y\" \"string type\" \"diffuse\"\n"
                   "Material \"mix\" \"string materials\" [\"x\" \"y\"]",
                   false));
}

TEST_CASE("raylex scene check refuses the same scenes as a render, and conflicting options") {
    const Folder folder;
    for (const char* line :
         {"Camera \"realistic\"", "Camera \"foo\"", "Camera \"perspective\" \"float fov\" 200",
          "PixelFilter \"gaussian\" \"float xradius\" -1", "Sampler \"halton\" \"integer pixelsamples\" 0",
          "Integrator \"path\" \"integer maxdepth\" -1", "Film \"rgb\" \"integer xresolution\" 0"}) {
        folder.write("refused.pbrt", std::string(line) + "\nWorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n");
        CAPTURE(line);
        const Outcome checked = run_raylex(folder, "scene check refused.pbrt");
        CAPTURE(checked.out, checked.err);
        CHECK(checked.code == 2);
        CHECK(contains(checked.err, "refused.pbrt:1"));
        const Outcome told = run_raylex(folder, "scene info refused.pbrt");
        CHECK(told.code == 0);
        CHECK(contains(told.err, "cannot be rendered: refused.pbrt:1"));
    }
    folder.write("room.pbrt", counted_scene);
    CHECK(run_raylex(folder, "scene check room.pbrt --only film-size").code == 2);
    const Outcome onto_itself = run_raylex(folder, "scene write room.pbrt -o room.pbrt");
    CHECK(onto_itself.code == 2);
    CHECK(contains(onto_itself.err, "this file is the input scene"));
    CHECK(folder.read("room.pbrt") == counted_scene);
}

TEST_CASE("raylex scene check lists all missing files, each with its line and the folders searched") {
    const Folder folder;
    folder.write("gaps.pbrt",
                 "WorldBegin\nLightSource \"infinite\" \"string filename\" \"no/sky.exr\"\n"
                 "MakeNamedMaterial \"wood\" \"string type\" \"diffuse\" NamedMaterial \"wood\"\n"
                 "Shape \"plymesh\" \"string filename\" \"no/mesh.ply\"\n");
    const Outcome outcome = run_raylex(folder, "scene check gaps.pbrt");
    INFO(outcome.out << outcome.err);
    CHECK(outcome.code == 1);
    // the missing mesh may use the wood
    CHECK(contains(outcome.out, "0 likely mistakes, 2 files that cannot be found"));
    CHECK(contains(outcome.err, "gaps.pbrt:2:24: cannot find file 'no/sky.exr'"));
    CHECK(contains(outcome.err, "gaps.pbrt:4:1: cannot find file 'no/mesh.ply'"));
    CHECK(contains(outcome.err, "looked in"));

    folder.write("sky.pbrt",
                 "WorldBegin\nLightSource \"infinite\" \"string filename\" \"no/sky.exr\"\n"
                 "MakeNamedMaterial \"wood\" \"string type\" \"diffuse\"\nShape \"sphere\"\n");
    CHECK(contains(run_raylex(folder, "scene check sky.pbrt").out, "'wood' is unused"));  // a sky uses no material

    folder.write("ptex.pbrt", "WorldBegin\nTexture \"a\" \"spectrum\" \"ptex\" \"string filename\" \"no/a.ptx\"\n");
    const Outcome ptex = run_raylex(folder, "render ptex.pbrt");
    CHECK(ptex.code == 2);
    CHECK(contains(ptex.err, "ptex.pbrt:2:31: cannot find file 'no/a.ptx'"));
    CHECK(contains(ptex.err, "raylex does not read ptex files: imagemap reads images"));
}

TEST_CASE("an unreadable file is an error at the place where the scene names it") {
    const Folder folder;
    folder.write("bad.spd", "400 1\n300 1\n");
    folder.write("bad.dat", "# radius thickness eta diameter\n1 2 3\n");
    folder.write("bad.png", "no picture");
    const auto check = [&](const std::string& scene, const std::string& what, const std::string& where) {
        folder.write("names.pbrt", "# a scene\n" + scene);
        const Outcome outcome = run_raylex(folder, "render names.pbrt --spp 1 -o out.exr");
        CAPTURE(scene, outcome.err);
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, what));
        CHECK(contains(outcome.err, "named by " + where));
    };
    check("WorldBegin\nLightSource \"infinite\" \"spectrum L\" \"bad.spd\"\n",
          "bad.spd: spectrum file: wavelength 300 follows 400", "'spectrum L' at names.pbrt:3");
    check("Camera \"realistic\" \"string lensfile\" \"bad.dat\"\nWorldBegin\nLightSource \"infinite\"\n",
          "bad.dat:2: 3 numbers in a row", "'lensfile' at names.pbrt:2");
    check("WorldBegin\n\nLightSource \"infinite\" \"string filename\" \"bad.png\"\n", "bad.png: unknown image format",
          "the infinite light at names.pbrt:4");
    check("WorldBegin\nLightSource \"infinite\"\nShape \"plymesh\" \"string filename\" \"bad.png\"\n", "bad.png",
          "the plymesh at names.pbrt:4");
}
