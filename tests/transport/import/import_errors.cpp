// Law 7 for scene files: every error names file, line, column, what was found and what was expected.
#include <catch2/catch.hpp>

#include "tests/transport/import_support.h"

using namespace import_test;

namespace {

struct Slip {
    const char* what;
    std::string text;
    int line, column;
    const char* message;  // part of the message
    const char* hint;     // part of the hint
};

const std::string quad_text = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";

const Slip syntax[] = {
    {"unknown directive", "WorldBegin\n  Shap \"sphere\"", 2, 3, "unknown directive 'Shap'", "did you mean Shape?"},
    {"a v3 directive", "WorldBegin\nWorldEnd", 2, 1, "unknown directive 'WorldEnd'", "pbrt-v3"},
    {"a value instead of a directive", "WorldBegin 3", 1, 12, "unknown directive '3'", ""},
    {"a string instead of a directive", "\"Shape\"", 1, 1, "expected a directive", ""},
    {"a stray bracket", "WorldBegin\n]", 2, 1, "found ']'", ""},
    {"an unclosed string", "WorldBegin\nShape \"sphere\n", 2, 7, "string is not closed", ""},
    {"an unclosed string at the end", "Shape \"sphere", 1, 7, "string is not closed", ""},
    {"an unknown escape", "WorldBegin Material \"dif\\qfuse\"", 1, 21, "unknown escape '\\q'", ""},
    {"a missing type", "WorldBegin Shape", 1, 17, "found the end of the file; expected a type in quotes after Shape",
     ""},
    {"a number for a type", "WorldBegin Shape 7", 1, 18, "found '7'; expected a type in quotes", ""},
    {"a missing number", "Translate 1 2\nWorldBegin", 2, 1,
     "found 'WorldBegin'; expected number 3 of 3 after Translate", ""},
    {"a letter for a number", "Rotate 30 0 x 1", 1, 13,
     "found 'x'; expected number 3 of 4 after Rotate (4 numbers: degrees, axis)", ""},
    {"a number that runs into letters", "Translate 1 2 3q", 1, 15, "found '3q'", ""},
    {"an infinite number", "Translate 1 inf 3", 1, 13, "not finite", ""},
    {"a number too large", "Translate 1 1e999 3", 1, 13, "too large", ""},
    {"a matrix without bracket", "Transform 1 0 0 0", 1, 11, "expected '['", ""},
    {"a matrix of 15", "Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0]", 1, 41, "expected number 16 of 16", ""},
    {"a matrix of 17", "Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1]", 1, 44, "expected ']'", ""},
    {"ActiveTransform without a word", "ActiveTransform \"All\"", 1, 17, "expected StartTime, EndTime or All", ""},
    {"ActiveTransform of another word", "ActiveTransform Sometimes", 1, 17, "found 'Sometimes'", ""},
    {"unknown parameter type", "WorldBegin\nShape \"sphere\"\n    \"flot radius\" 1", 3, 5,
     "unknown parameter type 'flot'", "did you mean 'float'?"},
    {"a v3 parameter type", "WorldBegin Shape \"sphere\" \"point from\" [0 0 0]", 1, 27,
     "unknown parameter type 'point'", "point3"},
    {"a parameter of one word", "WorldBegin Shape \"sphere\" \"radius\" 1", 1, 27,
     "expected a parameter, \"type name\"", ""},
    {"a parameter of three words", "WorldBegin Shape \"sphere\" \"float the radius\" 1", 1, 27,
     "shape 'sphere' has no parameter 'the'", ""},
    {"a parameter without value", "WorldBegin Shape \"sphere\" \"float radius\"", 1, 41,
     "expected a number for 'float radius'", ""},
    {"an empty list", "WorldBegin Shape \"sphere\" \"float radius\" []", 1, 27, "has no values", ""},
    {"an unclosed list", "WorldBegin Shape \"sphere\" \"float radius\" [1", 1, 42, "'[' is never closed", ""},
    {"a list in a list", "WorldBegin Shape \"sphere\" \"float radius\" [[1]]", 1, 43, "found '['; expected a number",
     ""},
    {"a string for a float", "WorldBegin Shape \"sphere\" \"float radius\" [\"1\"]", 1, 43,
     "found string \"1\"; expected a number", ""},
    {"a float for an integer", "Film \"rgb\" \"integer xresolution\" 1.5", 1, 34, "found '1.5'; expected an integer",
     ""},
    {"an integer of 33 bits", "Film \"rgb\" \"integer xresolution\" 4294967296", 1, 34, "of 32 bits", ""},
    {"a number for a string", "Film \"rgb\" \"string filename\" 3", 1, 30, "found '3'; expected a string", ""},
    {"a quoted boolean", "Film \"rgb\" \"bool savefp16\" \"true\"", 1, 28, "expected true or false", "without quotes"},
    {"another word for a boolean", "Film \"rgb\" \"bool savefp16\" yes", 1, 28, "found 'yes'; expected true or false",
     ""},
    {"an rgb of two", "WorldBegin Material \"diffuse\" \"rgb reflectance\" [1 1]", 1, 31,
     "2 numbers; expected a multiple of 3", ""},
    {"a spectrum of both", "WorldBegin Material \"conductor\" \"spectrum k\" [\"metal-Cu-k\" 3]", 1, 60,
     "found '3'; expected a string", ""},
    {"several options", "Option \"bool pixelstats\" true \"bool wavefront\" true\nWorldBegin", 2, 1,
     "several parameters after Option", ""},
    {"an unknown option", "Option \"bool disablepixeljiter\" true", 1, 8, "unknown option", "disablepixeljitter"},
};

const Slip meaning[] = {
    {"world directive too early", "Shape \"sphere\"", 1, 1, "Shape before WorldBegin", ""},
    {"option too late", "WorldBegin\nCamera \"perspective\"", 2, 1, "Camera after WorldBegin", ""},
    {"WorldBegin twice", "WorldBegin\n\nWorldBegin", 3, 1, "WorldBegin after WorldBegin", ""},
    {"no WorldBegin", "Film \"rgb\"\n", 2, 1, "ends before WorldBegin", ""},
    {"an open block", "WorldBegin\nAttributeBegin\n", 2, 1, "AttributeBegin is never closed", ""},
    {"an open object", "WorldBegin\nObjectBegin \"x\"\n", 2, 1, "ObjectBegin is never closed", ""},
    {"a lone end of an object", "WorldBegin\n ObjectEnd", 2, 2, "ObjectEnd without its ObjectBegin", ""},
    {"crossed blocks", "WorldBegin\nAttributeBegin\nObjectEnd", 3, 1, "ObjectEnd without its ObjectBegin",
     "AttributeBegin at line 2"},
    {"nested objects", "WorldBegin ObjectBegin \"a\"\nObjectBegin \"b\"", 2, 1, "inside ObjectBegin", ""},
    {"an instance in an object", "WorldBegin ObjectBegin \"a\"\nObjectInstance \"a\"", 2, 1, "cannot be nested", ""},
    {"an object twice", "WorldBegin ObjectBegin \"a\" ObjectEnd\nObjectBegin \"a\"", 2, 13, "defined twice", ""},
    {"an instance in perspective",
     "WorldBegin ObjectBegin \"a\" ObjectEnd\nConcatTransform [1 0 0 .3 0 1 0 0 0 0 1 0 0 0 0 1]\nObjectInstance \"a\"",
     3, 1, "an instance's transformation must be affine", "place the shapes without an instance"},
    {"an unknown object", "WorldBegin ObjectBegin \"chair\" ObjectEnd\nObjectInstance \"chairs\"", 2, 16,
     "no object is called 'chairs'", "'chair'"},
    {"an unknown material",
     "WorldBegin MakeNamedMaterial \"glass\" \"string type\" \"dielectric\"\n\nNamedMaterial \"glas\" Shape \"sphere\"",
     3, 15, "no material is called 'glas'", "'glass'"},
    {"a material of no type", "WorldBegin\nMakeNamedMaterial \"glass\" \"float eta\" 1.5", 2, 1, "has no type", ""},
    {"a material twice",
     "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"a\" \"string type\" "
     "\"diffuse\"",
     2, 19, "defined twice; the first is at test.pbrt:1", ""},
    {"a mix of an unknown material",
     "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mix\"\n\"string materials\" [\"b\" \"a\"]", 2, 1,
     "no material is called 'b'", ""},
    {"an unknown texture",
     "WorldBegin Texture \"wood\" \"spectrum\" \"constant\"\nMaterial \"diffuse\" \"texture reflectance\" \"woood\"", 2,
     20, "no texture is called 'woood'", "'wood'"},
    {"a texture used before it is there",
     "WorldBegin Texture \"a\" \"float\" \"scale\"\n \"texture tex\" \"b\"\nTexture \"b\" \"float\" \"constant\"", 2, 2,
     "no texture is called 'b'", "defined later"},
    {"a texture twice", "WorldBegin Texture \"a\" \"float\" \"constant\"\nTexture \"a\" \"float\" \"constant\"", 2, 9,
     "defined twice", ""},
    {"a texture of colours", "WorldBegin Texture \"a\" \"color\" \"constant\"", 1, 24,
     "expected \"float\" or \"spectrum\"", ""},
    {"alpha by a colour texture",
     "WorldBegin Texture \"a\" \"spectrum\" \"constant\"\n" + quad_text + " \"texture alpha\" \"a\"", 2, 1,
     "no float texture is called 'a'", ""},
    {"alpha by a string", "WorldBegin\nShape \"sphere\" \"string alpha\" \"a\"", 2, 16,
     "expected one \"float alpha\" or \"texture alpha\"", ""},
    {"a camera scaled by zero", "Scale 1 0 1\nCamera \"perspective\"", 2, 1, "cannot be inverted", ""},
    {"a rotation about nothing", "Rotate 30 0 0 0", 1, 1, "null axis", ""},
    {"a view along its up vector", "LookAt 0 0 0  0 1 0  0 1 0", 1, 1, "parallel", ""},
    {"a moving area light",
     "WorldBegin ActiveTransform EndTime Translate 1 0 0 AreaLightSource \"diffuse\"\nShape \"sphere\"", 2, 1,
     "an area light moves; expected lights that stand still", ""},
    {"a shape that is mirrored on its way", "WorldBegin ActiveTransform EndTime Scale 1 1 -1\nShape \"sphere\"", 2, 1,
     "only one of the transformations at the start and the end mirrors", ""},
    {"a camera that is mirrored on its way", "ActiveTransform EndTime Scale 1 1 -1\nCamera \"perspective\"", 2, 1,
     "only one of the transformations at the start and the end mirrors", ""},
    {"times that go backwards", "TransformTimes 1 0", 1, 1, "expected the earlier one first", ""},
    {"times that stand still", "TransformTimes 1 1", 1, 1, "expected the earlier one first", ""},
    {"a medium without a type", "MakeNamedMedium \"fog\" \"float g\" 0", 1, 1, "named medium 'fog' has no type", ""},
    {"a medium defined twice",
     "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMakeNamedMedium \"fog\" \"string type\" \"homogeneous\"",
     2, 17, "medium 'fog' is defined twice; the first is at test.pbrt:1", ""},
    {"an undefined medium", "WorldBegin\nMediumInterface \"\" \"fog\" Shape \"sphere\"", 2, 20,
     "no medium is called 'fog'", ""},
    {"an unknown plain option", "Option \"disable-pixel-jiter\" true", 1, 8, "unknown option", "disablepixeljitter"},
    {"a plain option without a value", "Option \"seed\" Identity", 1, 15, "expected true, false, a number", ""},
    {"an unknown Attribute target", "WorldBegin Attribute \"shapes\" \"float radius\" 2", 1, 22,
     "unknown target 'shapes'", ""},
    {"an unknown shape", "WorldBegin\nShape \"shpere\"", 2, 1, "unknown shape 'shpere'", "'sphere'"},
    {"a shape that is not there yet", "WorldBegin\nShape \"paraboloid\"", 2, 1,
     "shape 'paraboloid' is not supported yet", ""},
    {"a radius below zero", "WorldBegin Shape \"sphere\" \"float radius\" -1", 1, 12, "radius is not above 0", ""},
    {"a disk with a hole of less than nothing", "WorldBegin Shape \"disk\" \"float innerradius\" -1", 1, 12,
     "'innerradius' is below 0", ""},
    {"a mesh without vertices", "WorldBegin Shape \"trianglemesh\"", 1, 12, "no vertices", ""},
    {"a mesh without indices", "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]", 1, 12,
     "no \"integer indices\"", ""},
    {"an index out of range", "WorldBegin " + quad_text + "\n\"integer indices\" [0 1 3]", 2, 1,
     "index 3 (value 2 of 'indices') is out of range; expected 0 to 2", ""},
    {"a negative index", "WorldBegin " + quad_text + "\n\"integer indices\" [0 -1 2]", 2, 1, "index -1", ""},
    {"two indices", "WorldBegin " + quad_text + "\n\"integer indices\" [0 1]", 2, 1, "expected a multiple of 3", ""},
    {"vertices of another type", "WorldBegin Shape \"trianglemesh\"\n\"vector3 P\" [0 0 0 1 0 0 0 1 0]", 2, 1,
     "expected \"point3 P\"", ""},
    {"a NaN vertex", "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0\n 0 nan 0]", 2, 4, "at vertex 2", ""},
    {"a vertex beyond float", "WorldBegin Shape \"trianglemesh\"\n\"point3 P\" [0 0 0 1e300 0 0 0 1 0]", 2, 19,
     "beyond the range of float; expected a number for 'point3 P', at vertex 1", ""},
    {"a missing mesh", "WorldBegin Shape \"plymesh\"\n \"string filename\" \"no.ply\"", 2, 2,
     "cannot find file 'no.ply'", "looked in"},
    {"a plymesh of no file", "WorldBegin Shape \"plymesh\"", 1, 12, "plymesh without a file", ""},
    {"a missing image", "WorldBegin Texture \"a\" \"float\" \"imagemap\"\n\"string filename\" \"no.png\"", 2, 1,
     "cannot find file 'no.png'", ""},
    {"a missing spectrum", "WorldBegin Material \"conductor\"\n\"spectrum eta\" \"metal-Cuu-eta\"", 2, 1,
     "neither a named spectrum nor a file", "metal-Cu-eta"},
    {"a missing include", "Include \"no.pbrt\"", 1, 9, "cannot find file 'no.pbrt'", ""},
    {"an early import", "Import \"no.pbrt\"", 1, 1, "Import before WorldBegin", ""},
};

void check(const Slip& slip) {
    INFO(slip.what << ":\n" << slip.text);
    const raylex::Error error = error_of(slip.text);
    INFO(error.to_string());
    CHECK(error.file == "test.pbrt");
    CHECK(error.line == slip.line);
    CHECK(error.column == slip.column);
    CHECK(contains(error.message, slip.message));
    CHECK(contains(error.hint, slip.hint));
    // The excerpt is the line itself, so that the caret is below the mistake.
    std::string line = slip.text;
    for (int i = 1; i < slip.line; ++i) line.erase(0, line.find('\n') + 1);
    CHECK(error.excerpt == line.substr(0, line.find('\n')));
}

}  // namespace

TEST_CASE("a syntax error names line, column, what was found and what was expected", "[law7][import]") {
    for (const Slip& slip : syntax) check(slip);
}

TEST_CASE("a semantic error names line, column and close matches", "[law7][import]") {
    for (const Slip& slip : meaning) check(slip);
}

TEST_CASE("an error inside an included file names that file", "[law7][import]") {
    const Folder folder;
    folder.write("parts/broken.pbrt", "AttributeBegin\n  Shap \"sphere\"\nAttributeEnd\n");
    const auto scene =
        raylex::transport::import_pbrt(folder.write("scene.pbrt", "WorldBegin\nInclude \"parts/broken.pbrt\"\n"));
    REQUIRE_FALSE(scene);
    CHECK(scene.error().file == folder.path("parts/broken.pbrt"));
    CHECK(scene.error().line == 2);
    CHECK(scene.error().column == 3);
}

TEST_CASE("a file that includes itself indirectly is an error", "[law7][import]") {
    const Folder folder;
    folder.write("a.pbrt", "# a comment\n  Include \"parts/../b.pbrt\"");
    folder.write("b.pbrt", "Include \"a.pbrt\"");
    fs::create_directories(folder.path("parts"));
    const auto scene = raylex::transport::import_pbrt(folder.path("a.pbrt"));
    REQUIRE_FALSE(scene);
    CHECK(contains(scene.error().message, "includes itself"));
    CHECK(scene.error().file == folder.path("b.pbrt"));
}

TEST_CASE("a missing scene, a folder and a truncated gzip file are errors that name the file", "[law7][import]") {
    const Folder folder;
    const auto missing = raylex::transport::import_pbrt(folder.path("no.pbrt"));
    REQUIRE_FALSE(missing);
    CHECK(contains(missing.error().message, "cannot read this file"));
    CHECK(missing.error().file == folder.path("no.pbrt"));
    const auto directory = raylex::transport::import_pbrt(folder.path(""));
    REQUIRE_FALSE(directory);
    CHECK(contains(directory.error().message, "directory"));
    const auto truncated = raylex::transport::import_pbrt(
        folder.write("t.pbrt.gz", std::string("\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03\x0b", 11)));
    REQUIRE_FALSE(truncated);
    CHECK(contains(truncated.error().message, "truncated gzip"));
}

TEST_CASE("a long line is cut in the excerpt and the message still names the mistake", "[law7][import]") {
    std::string text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [";
    for (int i = 0; i < 1000; ++i) text += "1 2 3 ";
    const raylex::Error error = error_of(text + "x ]");
    CHECK(error.column == static_cast<int>(text.size()) + 1);
    CHECK(error.excerpt.size() < 200);
    CHECK(contains(error.message, "found 'x'"));
    CHECK(contains(error.message, "at vertex 1000"));
}
