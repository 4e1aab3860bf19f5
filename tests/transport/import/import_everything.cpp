// Every parameter of every type that pbrt-v4 reads, in the notations of public scenes: none is an error.
#include <catch2/catch.hpp>

#include "tests/transport/import_support.h"

namespace import_everything_test {
namespace {

using namespace import_test;
using raylex::transport::SceneDescription;

const char* const options = R"(
Option "disablepixeljitter" false  Option "bool disablewavelengthjitter" false  Option "disabletexturefiltering" false
Option "displacementedgescale" 1  Option "msereferenceimage" "a.exr"  Option "msereferenceout" "a.txt"
Option "rendercoordsys" "cameraworld"  Option "seed" 3  Option "forcediffuse" false  Option "pixelstats" false
Option "wavefront" false
ColorSpace "aces2065-1"  ColorSpace "rec2020"  ColorSpace "dci-p3"  ColorSpace "srgb"
Accelerator "kdtree" "integer intersectcost" 5 "integer traversalcost" 1 "float emptybonus" .5 "integer maxprims" 1
    "integer maxdepth" -1
Accelerator "bvh" "integer maxnodeprims" 4 "string splitmethod" "sah"
PixelFilter "mitchell" "float xradius" 2 "float yradius" [ 2 ] "float B" .3333 "float C" .3333
PixelFilter "sinc" "float xradius" 4 "float yradius" 4 "float tau" 3
PixelFilter "box" "float xradius" .5 "float yradius" .5
PixelFilter "triangle" "float xradius" [ 1.000000 ] "float yradius" [ 1.000000 ]
PixelFilter "gaussian" "float xradius" 1.5 "float yradius" 1.5 "float sigma" .5
Sampler "stratified" "integer xsamples" 4 "integer ysamples" 4 "bool jitter" true "integer seed" 0
Sampler "independent" "integer pixelsamples" 4 "integer seed" 2
Sampler "pmj02bn" "integer pixelsamples" 4 "integer seed" 2
Sampler "halton" "integer pixelsamples" 4 "integer seed" 2 "string randomization" "permutedigits"
Sampler "sobol" "integer pixelsamples" 4 "integer seed" 2 "string randomization" "fastowen"
Sampler "paddedsobol" "integer pixelsamples" 4 "integer seed" 2 "string randomization" "none"
Sampler "zsobol" "integer pixelsamples" 4 "integer seed" 2 "string randomization" "owen"
Integrator "mlt" "integer maxdepth" 5 "integer bootstrapsamples" 9 "integer chains" 9 "integer mutationsperpixel" 9
    "float sigma" .01 "float largestepprobability" .3 "bool regularize" false
Integrator "sppm" "integer maxdepth" 5 "integer photonsperiteration" -1 "float radius" 1 "integer seed" 3
Integrator "ambientocclusion" "bool cossample" true "float maxdistance" 10
Integrator "simplepath" "integer maxdepth" 5 "bool samplelights" true "bool samplebsdf" true
Integrator "lightpath" "integer maxdepth" 5  Integrator "randomwalk" "integer maxdepth" 5
Integrator "simplevolpath" "integer maxdepth" 5
Integrator "bdpt" "integer maxdepth" 5 "bool visualizestrategies" false "bool visualizeweights" false
    "bool regularize" true
Integrator "path" "integer maxdepth" 5 "bool regularize" true "string lightsampler" "exhaustive"
Integrator "volpath" "integer maxdepth" 5 "bool regularize" true "string lightsampler" "bvh" "float rrthreshold" [ 0 ]
Film "spectral" "integer nbuckets" 16 "float lambdamin" 360 "float lambdamax" 830 "string filename" "a.exr"
Film "gbuffer" "string coordinatesystem" "world" "bool savefp16" true
Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "integer pixelbounds" [0 40 0 30]
    "float cropwindow" [0 1 0 1] "float diagonal" 35 "string filename" "a.png" "bool savefp16" false
    "string sensor" "cie1931" "float iso" 100 "float whitebalance" 0 "float exposuretime" 1 "float maxcomponentvalue" 9
TransformTimes 0 1
Camera "orthographic" "float frameaspectratio" 1.3 "float screenwindow" [-1 1 -1 1] "float lensradius" 0
    "float focaldistance" 10 "float shutteropen" 0 "float shutterclose" 1
Camera "realistic" "string lensfile" [ "lens.dat" ] "float focusdistance" [ 40 ] "float aperturediameter" [ 8.7 ]
    "string aperture" "pentagon"
Camera "spherical" "string mapping" "equirectangular" "float frameaspectratio" 1.3 "float screenwindow" [-1 1 -1 1]
    "float lensradius" 0 "float focaldistance" 10
Camera "perspective" "float frameaspectratio" 1.3 "float screenwindow" [-1 1 -1 1] "float lensradius" 0
    "float focaldistance" 10 "float shutteropen" 0 "float shutterclose" 1 "float fov" 30
WorldBegin
)";

const char* const lights = R"(
CoordinateSystem "here"  CoordSysTransform "here"  CoordSysTransform "camera"  CoordSysTransform "world"
Attribute "shape" "float radius" 3  Attribute "material" "float roughness" .1 "rgb reflectance" [.1 .1 .1]
Attribute "light" "float scale" 2  Attribute "medium" "float g" .1  Attribute "texture" "float scale" 1
LightSource "point" "rgb I" [1 1 1] "float scale" 1 "float power" 3 "point3 from" [0 0 10]
LightSource "spot" "blackbody I" 3000 "float scale" 1 "float power" 3 "point3 from" [0 0 10] "point3 to" [0 0 0]
    "float coneangle" 30 "float conedeltaangle" 5
LightSource "goniometric" "spectrum I" "stdillum-D65" "string filename" "a.pfm" "float scale" 1 "float power" 100
LightSource "projection" "string filename" "a.pfm" "float fov" 30 "float scale" 1 "float power" 100
LightSource "distant" "rgb L" [1 1 1] "float illuminance" 3 "point3 from" [0 0 0] "point3 to" [0 0 1] "float scale" 1
LightSource "infinite" "string filename" "a.pfm" "float illuminance" 5 "float scale" 1
LightSource "infinite" "blackbody L" 6500 "float scale" 7 "point3 portal" [9 2 -5  9 2 -2  9 0 -2  9 0 -5]
LightSource "infinite" "string filename" "a.pfm" "float scale" 16 "point3 portal" [0 0 0 0 1 0 1 1 0 1 0 0]
    "string filename" "a.pfm" "float scale" 15 "point3 portal" [0 0 0 0 2 0 2 2 0 2 0 0]
AttributeBegin
    AreaLightSource "diffuse" "float power" 5 "bool twosided" true "string filename" "a.pfm"
    Shape "sphere" "float alpha" 0
AttributeEnd
)";

const char* const textures = R"(
Texture "bilerp" "spectrum" "bilerp" "rgb v00" [0 0 0] "rgb v01" [1 0 0] "rgb v10" [0 1 0] "rgb v11" [1 1 1]
    "string mapping" "uv" "float uscale" 2 "float vscale" 2 "float udelta" .1 "float vdelta" .1
Texture "corners" "float" "bilerp" "float v00" 0 "float v01" 1 "float v10" 1 "float v11" 0
Texture "solid" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [0 0 0] "spectrum tex2" [300 .3 800 .3]
Texture "flat" "float" "checkerboard" "integer dimension" 2 "float tex1" .3 "texture tex2" "corners"
    "string mapping" "planar" "vector3 v1" [1 0 0] "vector3 v2" [0 1 0]
Texture "constant" "spectrum" "constant" "rgb value" [.1 .1 .1]
Texture "dots" "spectrum" "dots" "rgb inside" [1 1 1] "rgb outside" [0 0 0] "float uscale" 10
Texture "fbm" "float" "fbm" "integer octaves" 4 "float roughness" .5
TransformBegin Scale 3 3 3 Texture "wrinkled" "float" "wrinkled" "integer octaves" 4 "float roughness" .5 TransformEnd
Texture "windy" "float" "windy"
Texture "marble" "spectrum" "marble" "integer octaves" 4 "float roughness" .5 "float scale" 1 "float variation" .2
Texture "image" "spectrum" "imagemap" "string wrap" "black" "string filter" "EWA" "float maxanisotropy" 4
    "float scale" 1 "bool invert" false "string filename" "a.pfm" "string encoding" "gamma 2.2"
Texture "cylinder" "float" "imagemap" "string wrap" "clamp" "string filter" "trilinear" "string filename" [ "a.pfm" ]
    "string encoding" "linear" "string mapping" "cylindrical"
Texture "ball" "float" "imagemap" "string wrap" "octahedralsphere" "string filter" "point" "string filename" "a.pfm"
    "string encoding" "sRGB" "string mapping" "spherical"
Texture "sides" "float" "directionmix" "float tex1" .1 "texture tex2" "fbm" "vector3 dir" [0 1 0]
Texture "mix" "spectrum" "mix" "texture tex1" "image" "rgb tex2" [1 1 1] "texture amount" "ball"
Texture "scale" "spectrum" "scale" "texture tex" "image" "texture scale" "cylinder"
)";

const char* const materials = R"(
MakeNamedMaterial "coat" "string type" "coateddiffuse" "texture reflectance" "bilerp" "float uroughness" .1
    "float vroughness" .1 "float roughness" .1 "float thickness" .01 "float eta" 1.5 "integer maxdepth" 10
    "integer nsamples" 1 "float g" 0 "rgb albedo" [0 0 0] "texture displacement" "fbm" "bool remaproughness" true
MakeNamedMaterial "gilt" "string type" "coatedconductor" "float interface.roughness" .1 "float interface.uroughness" .1
    "float interface.vroughness" .1 "float thickness" .01 "float interface.eta" 1.5 "integer maxdepth" 10
    "integer nsamples" 1 "float g" 0 "texture albedo" "image" "bool remaproughness" true "float conductor.roughness" .1
    "float conductor.uroughness" .1 "float conductor.vroughness" .1 "spectrum conductor.eta" "metal-Ag-eta"
    "spectrum conductor.k" [ "k.spd" ] "string normalmap" "a.pfm"
MakeNamedMaterial "metal" "string type" "conductor" "rgb eta" [1.6 .8 .5] "rgb k" [9 6 4] "float uroughness" .1
    "float vroughness" .2 "float roughness" .2 "bool remaproughness" false
MakeNamedMaterial "grey" "string type" "conductor" "texture reflectance" "image" "texture roughness" "ball"
MakeNamedMaterial "glass" "string type" "dielectric" "float eta" 1.4 "texture uroughness" "ball" "float vroughness" .2
    "float roughness" 0 "bool remaproughness" false
MakeNamedMaterial "prism" "string type" [ "dielectric" ] "spectrum eta" "glass-BAF10"
MakeNamedMaterial "pane" "string type" "thindielectric" "spectrum eta" "glass-BK7"
MakeNamedMaterial "leaf" "string type" "diffusetransmission" "rgb reflectance" [.1 .1 .1]
    "texture transmittance" "image" "float scale" 1
MakeNamedMaterial "fur" "string type" "hair" "rgb sigma_a" [1 2 3] "float eta" 1.55 "float beta_m" .3
    " float beta_n" .3 "float alpha" 2
MakeNamedMaterial "dyed" "string type" "hair" "rgb color" [.5 .5 .5]
MakeNamedMaterial "bleached" "string type" "hair" "texture reflectance" "image"
MakeNamedMaterial "brown" "string type" "hair" "float eumelanin" .3 "float pheomelanin" .1
MakeNamedMaterial "skin" "string type" "subsurface" "rgb mfp" [.1 .1 .1] "texture reflectance" "image" "float eta" 1.3
    "float uroughness" .1 "float vroughness" .1 "float roughness" .1 "float scale" 2 "float g" .1
    "bool remaproughness" true
MakeNamedMaterial "wax" "string type" "subsurface" "rgb sigma_a" [.1 .1 .1] "rgb sigma_s" [1 1 1]
MakeNamedMaterial "sauce" "string type" "subsurface" "string name" "Ketchup"
MakeNamedMaterial "paint" "string type" "measured" "string filename" "a.bsdf"
MakeNamedMaterial "some" "string type" "mix" "string materials" [ "coat" "gilt" ] "float amount" .3
MakeNamedMaterial "border" "string type" "interface"
MakeNamedMaterial "nothing" "string type" ""
MakeNamedMaterial "holes" "string type" "mix" "string materials" [ "border" "some" ] "texture amount" "ball"
MakeNamedMedium "fog" "string type" "homogeneous" "string preset" "Skin1" "rgb Le" [1 1 1] "float Lescale" 2
    "float scale" 1 "float g" 0
MakeNamedMedium "grid" "string type" "uniformgrid" "float density" [1 1 1 1 1 1 1 1] "integer nx" 2 "integer ny" 2
    "integer nz" 2 "point3 p0" [0 0 0] "point3 p1" [1 1 1] "float g" 0 "float scale" 1 "rgb sigma_a" [1 1 1]
    "rgb sigma_s" [1 1 1] "rgb Le" [1 1 1] "float Lescale" [1 1 1 1 1 1 1 1]
MakeNamedMedium "fire" "string type" "uniformgrid" "float density" [1 1 1 1 1 1 1 1]
    "float temperature" [1 1 1 1 1 1 1 1] "float temperaturescale" 100 "float temperatureoffset" 1
    "float temperaturecutoff" 1 "integer nx" 2 "integer ny" 2
    "integer nz" 2 "string preset" "Wholemilk"
MakeNamedMedium "colours" "string type" "rgbgrid" "integer nx" 1 "integer ny" 1 "integer nz" 1 "rgb sigma_a" [1 1 1]
    "rgb sigma_s" [1 1 1] "rgb Le" [1 1 1] "float Lescale" 3 "float scale" 3 "float g" .3 "point3 p0" [0 0 0]
    "point3 p1" [1 1 1]
MakeNamedMedium "cloud" "string type" "cloud" "float density" 1 "float frequency" 5 "float wispiness" 1
    "point3 p0" [0 0 0] "point3 p1" [1 1 1] "float g" 0 "rgb sigma_a" [1 1 1] "rgb sigma_s" [1 1 1]
MakeNamedMedium "smoke" "string type" "nanovdb" "string filename" "a.nvdb" "string gridname" "density"
    "string temperaturename" "heat" "float LeScale" 1 "float Lescale" 1 "float temperatureoffset" 1
    "float temperaturecutoff" 1 "float temperaturescale" 1 "float g" 0 "float scale" 1 "spectrum sigma_a" [200 0 900 0]
    "spectrum sigma_s" [200 1 900 1]
)";

const char* const shapes = R"(
NamedMaterial "coat"
Shape "sphere" "float radius" 1 "float zmin" -1 "float zmax" 1 "float phimax" 360 "float alpha" 1
Shape "cylinder" "float radius" 1 "float zmin" -1 "float zmax" 1 "float phimax" 360
Shape "disk" "float radius" 1 "float height" 1 "float innerradius" 0 "float phimax" 360 "texture alpha" "ball"
Shape "bilinearmesh" "point3 P" [ -1 0 -2  1 0 -2  -1 1 -2  1 1 -2 ]
Shape "bilinearmesh" "point3 P" [ -1 0 -2  1 0 -2  -1 1 -2  1 1 -2 ] "integer indices" [0 1 2 3]
    "normal N" [0 0 1 0 0 1 0 0 1 0 0 1] "point2 uv" [0 0 0 1 1 0 1 1] "integer faceIndices" [0]
    "string emissionfilename" "a.pfm"
Shape "loopsubdiv" "integer levels" [1] "string scheme" "loop" "integer indices" [0 1 2 0 2 3]
    "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]
Shape "plymesh" "string filename" "a.ply" "texture displacement" "fbm" "float edgelength" 1
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]
    "vector3 S" [1 0 0 1 0 0 1 0 0 1 0 0] "normal N" [0 0 1 0 0 1 0 0 1 0 0 1] "integer faceIndices" [0 1]
    "point2 uv" [0 0 0 1 1 0 1 1]
Shape "curve" "string type" [ "cylinder" ] "point3 P" [0 0 0 0 1 0 0 2 0 0 3 1] "float width0" .01 "float width1" .001
    "integer splitdepth" 3
Shape "curve" "point3 P" [0 0 0 0 1 0 0 2 0 0 3 1] "float width" .01 "string basis" "bspline" "integer degree" 3
Shape "curve" "string type" "ribbon" "point3 P" [0 0 0 0 1 0 0 2 0] "string basis" "bezier" "integer degree" 2
    "normal N" [1 0 0 1 0 0]
AttributeBegin
    ReverseOrientation  Identity  Translate 1 0 0  Rotate 90 1 0 0  Scale 1 1 -19
    Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 303.22 161.314 -411.308 1  ]
    ConcatTransform [ 1 1.2e-16 -1.2e-16 0 -4e-17 0.34 -2e-16 0 1e-16 7e-16 1 0 -3 -42 15 1  ]
    MediumInterface "fog" ""  Material ""  Shape "sphere"
    MediumInterface "" "grid"  Material "interface"  Shape "sphere"
    MediumInterface "cloud"  NamedMaterial "nothing"  Shape "sphere"
AttributeEnd
ObjectBegin "thing"
    AttributeBegin NamedMaterial "holes" Shape "sphere" AttributeEnd
ObjectEnd
ObjectBegin "empty" ObjectEnd
AttributeBegin
    ActiveTransform StartTime  Translate 0 1 0  ActiveTransform EndTime  Translate 1 0 0  ActiveTransform All
    ObjectInstance "thing"  ObjectInstance "empty"  Shape "sphere"
AttributeEnd
Include "more.pbrt" "spectrum sigma_s" [300 160 830 160]
Import "other.pbrt"
NamedMaterial "nobody"
)";

}  // namespace

TEST_CASE("every directive and parameter that pbrt-v4 reads is supported", "[import]") {
    const Folder folder;
    folder.write("a.pfm", "PF\n1 1\n-1\n" + std::string(12, '\0'));
    folder.write("a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                 "property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
    folder.write("k.spd", "300 1\n900 2\n");
    for (const char* unread : {"lens.dat", "a.bsdf", "a.nvdb"}) folder.write(unread, "read when it is used");
    folder.write("more.pbrt",
                 "MakeNamedMedium \"later\" \"string type\" \"homogeneous\" \"spectrum sigma_a\" [300 1 800 1]");
    folder.write("other.pbrt", "Texture \"other\" \"float\" \"constant\" \"float value\" 1");
    const SceneDescription scene =
        scene_of(std::string(options) + lights + textures + materials + shapes, folder.path("s.pbrt"));
    CHECK(scene.lights.size() == 8);
    CHECK(scene.textures.size() == 17);
    CHECK(scene.media.size() == 7);
    CHECK(scene.shapes.size() == 15);
    CHECK(scene.objects.size() == 3);  // including the shape that moves
    CHECK(scene.instances.size() == 3);
}

}  // namespace import_everything_test
