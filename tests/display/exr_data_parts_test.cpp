// Parts without a display channel: cryptomatte ids are float bit patterns and must be stored exactly.
#include <bit>

#include <catch2/catch.hpp>

#include <ImfMultiPartInputFile.h>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/output/writer/exr_writer.h"
#include "files.h"

using namespace raylex::test;
using namespace raylex::display;

TEST_CASE("a data part is written bit by bit, its attributes into its own header and the first") {
    const Folder folder;
    ChannelDefinition beauty;
    beauty.name = "beauty";
    beauty.style = ChannelStyle::expression;
    const FrameBuffer buffer({3, 2}, std::vector<ChannelDefinition>{beauty});
    // A negative number, the smallest and the largest exponents that an id can have, and odd mantissas.
    const std::vector<std::uint32_t> ids{0x13851a76, 0xb24b26d4, 0x809bc361, 0xff6dcc85, 0x7f0e5296, 0};
    std::vector<float> values;
    for (const std::uint32_t id : ids) values.push_back(std::bit_cast<float>(id));
    for (int i = 0; i < 6; ++i) values.push_back(static_cast<float>(i) / 6);
    ImageDescription description;
    const std::string manifest(5000, 'x');  // longer than shared attributes can be
    description.data_parts.push_back({"CryptoObject",
                                      {"CryptoObject00.R", "CryptoObject00.G"},
                                      {{"cryptomatte/3ae39a5/manifest", manifest}},
                                      [&values](const PixelRegion&) { return values; }});
    const std::string path = folder.path("matte.exr");
    REQUIRE(write_exr(path, buffer, 0, description));
    const auto image = read_exr(path);
    REQUIRE(image);
    const ImageLayer* layer = image->layer("CryptoObject00");
    REQUIRE(layer != nullptr);
    CHECK(layer->part == "CryptoObject");
    for (const ImagePlane& plane : layer->planes) CHECK(plane.stored == StoredType::single_float);
    for (std::size_t i = 0; i < 6; ++i) {
        CHECK(std::bit_cast<std::uint32_t>(layer->plane("R")->values[i]) == ids[i]);
        CHECK(layer->plane("G")->values[i] == values[6 + i]);
    }
    Imf::MultiPartInputFile file(path.c_str());
    REQUIRE(file.parts() == 2);
    for (int part = 0; part < 2; ++part)
        CHECK(file.header(part).typedAttribute<Imf::StringAttribute>("cryptomatte/3ae39a5/manifest").value() ==
              manifest);
    CHECK(file.header(1).typedAttribute<Imf::StringAttribute>("colorInteropID").value() == "data");
}
