#include "display/output/writer/exr_writer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/output/color/primaries.h"
#include "display/output/splits/split_check.h"
#include "display/output/splits/split_sum.h"
#include "files.h"

using namespace raylex::test;
using namespace raylex::display;

namespace {

constexpr int width = 5, height = 3;
constexpr ChannelId beauty_id = 0;

ChannelDefinition expression(const std::string& name, const std::string& text) {
    ChannelDefinition channel;
    channel.name = name;
    channel.style = ChannelStyle::expression;
    channel.expression = text;
    return channel;
}

ChannelDefinition plain(const std::string& name, ChannelType type, const std::string& space, float miss = 0) {
    ChannelDefinition channel;
    channel.name = name;
    channel.type = type;
    channel.rule = FilterRule::zmin;
    channel.space = space;
    channel.miss_value = miss;
    return channel;
}

std::vector<ChannelDefinition> channels() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    std::vector<ChannelDefinition> list{expression("beauty", ""),
                                        expression("diffuse", "C<RD>[<L.>O]"),
                                        expression("specular", "C<RS>[<L.>O]"),
                                        expression("rest", ""),
                                        plain("z", ChannelType::real, "camera", inf),
                                        plain("Nn", ChannelType::normal, "camera"),
                                        plain("id", ChannelType::integer, ""),
                                        plain("VLen", ChannelType::real, "camera", inf)};
    list[2].dialect = raylex::lpe::Dialect::osl;
    list[3].rest_of = {1, 2};
    return list;
}

// Thirds and sevenths, which are inexact in float, so rounding has an effect.
double light(int pixel, int component, int channel) {
    return (pixel + 1) / 3.0 + component / 7.0 + 1e-3 * channel;
}

/// One sample per pixel; every third pixel is a miss.
FrameBuffer filled() {
    const std::vector<ChannelDefinition> list = channels();
    FrameBuffer buffer({width, height}, list);
    for (int pixel = 0; pixel < width * height; ++pixel) {
        SampleTable table(list, 1);
        CameraRow row;
        row.pixel_x = pixel % width;
        row.pixel_y = pixel / width;
        table.begin(std::span(&row, 1));
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (ChannelId id = 1; id <= 3; ++id) {
                table.raw_values(id)[c] = light(pixel, c, id);
                sum += light(pixel, c, id);
            }
            table.raw_values(beauty_id)[c] = sum;
        }
        for (ChannelId id = 0; id <= 3; ++id) table.touch(id);
        if (pixel % 3 != 0) {
            table.raw_values(4)[0] = 2.5 + pixel;
            table.raw_values(5)[2] = -1;
            table.raw_values(6)[0] = pixel == 1 ? -2 : 16'777'217;  // one more than float can represent
            table.raw_values(7)[0] = 1e300;                         // larger than any float
            for (ChannelId id = 4; id <= 7; ++id) {
                table.touch(id);
                table.set_row_state(id, 0, SampleTable::RowState::written);
            }
            table.depth[0] = 1;
            table.opacity[0] = raylex::RgbD(1.0);
        }
        buffer.accumulate(table);
    }
    return buffer;
}

ImageDescription description() {
    ImageDescription result;
    result.attributes = {{"raylex/seed", "7"}, {"raylex/config", std::string(3000, 'c')}, {"software", "raylex 0.1"}};
    result.partitions = {{"auto", "", {"diffuse", "specular", "rest"}}};
    result.chromaticities = {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
    result.world_to_camera = {{{1, 0, 0, 10}, {0, 1, 0, 20}, {0, 0, 1, 30}, {0, 0, 0, 1}}};
    result.world_to_screen = {{{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 1, -1}, {0, 0, 1, 0}}};
    return result;
}

ExrImage written(const Folder& folder) {
    const auto status = write_exr(folder.path("a.exr"), filled(), beauty_id, description());
    if (!status) FAIL(status.error().message);
    auto image = read_exr(folder.path("a.exr"));
    if (!image) FAIL(image.error().message);
    return std::move(*image);
}

}  // namespace

TEST_CASE("every pixel of the frame buffer is read back, rounded to float once", "[display][exr]") {
    const Folder folder;
    const ExrImage image = written(folder);
    CHECK(image.width == width);
    CHECK(image.height == height);
    CHECK(image.layer_names() == std::vector<std::string>{"", "diffuse", "specular", "rest", "z", "Nn", "VLen", "id"});
    const FrameBuffer buffer = filled();
    for (ChannelId id = 1; id <= 3; ++id) {
        const std::vector<double> expected = buffer.resolve(id);
        const auto planes = image.layer(channels()[static_cast<std::size_t>(id)].name)->triple();
        for (std::size_t i = 0; i < width * height; ++i)
            for (std::size_t c = 0; c < 3; ++c) CHECK(planes[c]->values[i] == static_cast<float>(expected[3 * i + c]));
    }
    const ImageLayer* beauty = image.layer("");
    REQUIRE(beauty->planes.size() == 4);
    CHECK(beauty->planes[3].name == "A");
    CHECK(beauty->planes[3].values[0] == 0);
    CHECK(beauty->planes[3].values[1] == 1);
    CHECK(beauty->planes[0].stored == StoredType::single_float);
    CHECK(beauty->planes[1].values[4] ==
          Approx(light(4, 1, 1) + light(4, 1, 2) + light(4, 1, 3)).epsilon(1e-7));  // float rounding
    CHECK(image.layer("z")->plane("Z")->values[2] == 4.5f);
    CHECK(image.layer("Nn")->plane("Z")->values[1] == -1);
    CHECK(image.layer("Nn")->plane("X")->values[1] == 0);
    CHECK(image.layer("id")->planes[0].stored == StoredType::unsigned_int);
}

TEST_CASE("the header contains the result of every partition that a reader computes", "[display][exr][law1]") {
    const Folder folder;
    ImageDescription with_wrong = description();
    with_wrong.partitions.push_back({"short", "", {"diffuse", "specular"}});
    with_wrong.partitions.push_back({"of_rest", "rest", {"diffuse"}});
    with_wrong.partitions.push_back({"typo", "", {"difuse"}});
    REQUIRE(write_exr(folder.path("a.exr"), filled(), beauty_id, with_wrong).ok());
    const auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image.ok());
    const auto results = check_declared_splits(*image);
    REQUIRE(results.ok());
    REQUIRE(results->size() == 3);
    for (const SplitResult& verdict : *results) {
        std::string text = image->attributes.at("verdict/" + verdict.partition);
        CHECK(text.size() == 224);  // the reserved length
        text.erase(text.find_last_not_of(' ') + 1);
        CHECK(text == result_attribute(verdict, verdict.layers.size()));
    }
    CHECK(image->attributes.at("verdict/auto").starts_with("holds; largest relative error "));
    CHECK(image->attributes.at("verdict/short").starts_with("does not hold; "));
    CHECK(image->attributes.count("verdict/typo") == 0);
}

TEST_CASE("each kind of channel is stored according to its row of the table", "[display][exr]") {
    ImageDescription chosen = description();
    const raylex::SourceLocation where{"job.toml", 3, 5};
    REQUIRE(override_exr_storage(chosen.storage, "light", "half piz", where).ok());
    REQUIRE(override_exr_storage(chosen.storage, "normal", "rle half", where).ok());
    REQUIRE(override_exr_storage(chosen.storage, "value", "none", where).ok());
    const Folder folder;
    REQUIRE(write_exr(folder.path("a.exr"), filled(), beauty_id, chosen).ok());
    {
        Imf::MultiPartInputFile file(folder.path("a.exr").c_str());
        CHECK(file.header(0).compression() == Imf::PIZ_COMPRESSION);
        CHECK(file.header(0).channels().findChannel("A")->type == Imf::HALF);
        CHECK(file.header(2).channels().findChannel("specular.B")->type == Imf::HALF);
        CHECK(file.header(4).compression() == Imf::NO_COMPRESSION);
        CHECK(file.header(4).channels().findChannel("Z")->type == Imf::FLOAT);
        CHECK(file.header(5).compression() == Imf::RLE_COMPRESSION);
        REQUIRE(file.header(7).channels().findChannel("id") != nullptr);
        CHECK(file.header(7).channels().findChannel("id")->type == Imf::UINT);
    }
    const auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image.ok());
    const float stored = image->layer("diffuse")->triple()[0]->values[4];
    CHECK(stored == static_cast<float>(half(static_cast<float>(light(4, 0, 1)))));
    CHECK(image->attributes.at("storage/diffuse") == "half piz");
    CHECK(image->attributes.at("verdict/auto").find("bound 0.000977") != std::string::npos);  // 2^-10
    CHECK(check_declared_splits(*image)->front().holds);

    // "all" changes only what can be changed: depth and ids keep their type.
    ExrStorageTable table = default_exr_storage();
    REQUIRE(override_exr_storage(table, "all", "half zips", where).ok());
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::light)]) == "half zips");
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::value)]) == "float zips");
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::id)]) == "uint zips");
}

TEST_CASE("presets choose the storage of light, and never halve what is not light", "[display][exr]") {
    const auto texts = [](const std::string& name) {
        ExrStorageTable table = default_exr_storage();
        table[0] = {StoredType::half_float, ExrCompression::dwab};  // a preset replaces what was set before
        REQUIRE(use_exr_preset(table, name, {}).ok());
        std::vector<std::string> list;
        for (const auto& each : table) list.push_back(storage_text(each));
        return list;
    };
    using List = std::vector<std::string>;
    CHECK(texts("nuke") == List{"half zips", "float zips", "float zips", "float zips", "float zips", "uint zips"});
    CHECK(texts("blender") == List{"half zip", "half zip", "half zip", "float zip", "float zip", "uint zips"});
    CHECK(texts("archive") == List{"float zip", "float zip", "float zip", "float zip", "float zip", "uint zips"});
    ExrStorageTable table = default_exr_storage();
    const auto status = use_exr_preset(table, "nukes", {"job.toml", 3, 5});
    REQUIRE(!status.ok());
    CHECK(status.error().line == 3);
    CHECK(status.error().hint.find("did you mean 'nuke'") != std::string::npos);
}

TEST_CASE("storage that would make a channel useless is refused", "[display][exr][law7]") {
    const auto message = [](const std::string& kind, const std::string& text) {
        ExrStorageTable table = default_exr_storage();
        const auto status = override_exr_storage(table, kind, text, {"job.toml", 3, 5});
        if (status.ok()) return std::string();
        CHECK(status.error().line == 3);
        return status.error().message + status.error().hint;
    };
    CHECK(message("position", "half").find("expected float") != std::string::npos);
    CHECK(message("value", "half").find("expected float") != std::string::npos);
    CHECK(message("id", "float").find("expected uint") != std::string::npos);
    CHECK(message("light", "uint").find("expected float or half") != std::string::npos);
    for (const char* lossy : {"b44", "b44a", "pxr24"})
        CHECK(message("light", lossy).find("loses bits") != std::string::npos);
    for (const char* kind : {"normal", "position", "value", "id"})
        for (const char* lossy : {"dwaa", "dwab:10"}) CHECK(message(kind, lossy).find("must not") != std::string::npos);
    for (const char* level : {"dwaa:", "dwaa:-1", "dwaa:x", "dwaa:1e9", "zip:3", "dwab:nan"})
        CHECK(message("light", level).find("has an invalid level") != std::string::npos);
    ExrStorageTable table = default_exr_storage();
    REQUIRE(override_exr_storage(table, "all", "dwaa:60", {}).ok());
    REQUIRE(override_exr_storage(table, "light", "half dwab", {}).ok());
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::light)]) == "half dwab:45");
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::color)]) == "float dwaa:60");
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::value)]) == "float zip");
    CHECK(storage_text(table[static_cast<std::size_t>(ChannelKind::id)]) == "uint zips");
    CHECK(message("light", "pizz").find("did you mean 'piz'") != std::string::npos);
    CHECK(message("lights", "piz").find("did you mean 'light'") != std::string::npos);
    CHECK(message("light", "").find("is empty") != std::string::npos);
}

TEST_CASE("light beyond half becomes the largest half and is counted", "[display][exr][law6]") {
    std::vector<ChannelDefinition> list{expression("beauty", "")};
    FrameBuffer buffer({2, 1}, list);
    SampleTable table(list, 1);
    const CameraRow row;
    table.begin(std::span(&row, 1));
    for (int c = 0; c < 3; ++c) table.raw_values(0)[c] = 1e6;
    table.touch(0);
    buffer.accumulate(table);
    ImageDescription chosen;
    REQUIRE(override_exr_storage(chosen.storage, "light", "half", {}).ok());
    const Folder folder;
    REQUIRE(write_exr(folder.path("a.exr"), buffer, 0, chosen).ok());
    const auto image = read_exr(folder.path("a.exr"));
    CHECK(image->layer("")->planes[0].values[0] == 65504);
    CHECK(image->attributes.at("repaired/beauty") ==
          "0 values not a number, set to 0; 3 beyond half, set to the largest");
}

TEST_CASE("known primaries have their interop id, others none", "[display][exr]") {
    CHECK(color_interop_id(rec709_primaries()) == "lin_rec709_scene");
    CHECK(color_interop_id(aces_ap0_primaries()) == "lin_ap0_scene");
    CHECK(color_interop_id({{0.7, 0.3}, {0.2, 0.7}, {0.1, 0.05}, {0.31, 0.33}}) == "unknown");
}

TEST_CASE("a split written by raylex holds in the file", "[display][exr][law1]") {
    const Folder folder;
    const ExrImage image = written(folder);
    const auto results = check_declared_splits(image);
    REQUIRE(results.ok());
    REQUIRE(results->size() == 1);
    CHECK((*results)[0].partition == "auto");
    CHECK((*results)[0].holds);
    CHECK((*results)[0].largest_relative > 0);  // rounding has an effect, so the test is meaningful
    const auto short_sum = check_split(image, "", {"diffuse", "specular"});
    REQUIRE(short_sum.ok());
    CHECK(!short_sum->holds);
}

TEST_CASE("parts that Blender cannot use come after all others, and integers last", "[display][exr]") {
    const std::vector<ChannelDefinition> list{expression("beauty", ""),
                                              plain("VLen", ChannelType::real, ""),
                                              plain("u", ChannelType::real, ""),
                                              plain("k", ChannelType::integer, ""),
                                              plain("id", ChannelType::integer, ""),
                                              plain("zfar", ChannelType::real, ""),
                                              plain("Depth", ChannelType::real, ""),
                                              plain("shot.x", ChannelType::real, ""),
                                              plain("z", ChannelType::real, ""),
                                              plain("Nn", ChannelType::normal, "")};
    const Folder folder;
    REQUIRE(write_exr(folder.path("a.exr"), FrameBuffer({2, 2}, list), 0, {}).ok());
    Imf::MultiPartInputFile file(folder.path("a.exr").c_str());
    std::vector<std::string> names;
    for (int part = 0; part < file.parts(); ++part) names.push_back(file.header(part).name());
    CHECK(names == std::vector<std::string>{"rgba", "u", "Depth", "shot.x", "z", "Nn", "VLen", "zfar", "k", "id"});
}

TEST_CASE("parts, channels and attributes are where the design specifies", "[display][exr]") {
    const Folder folder;
    written(folder);
    Imf::MultiPartInputFile file(folder.path("a.exr").c_str());
    REQUIRE(file.parts() == 8);
    const auto text = [&file](int part, const std::string& name) {
        const auto* attribute = file.header(part).findTypedAttribute<Imf::StringAttribute>(name);
        return attribute == nullptr ? std::string("(none)") : attribute->value();
    };
    CHECK(file.header(0).name() == "rgba");
    CHECK(file.header(1).name() == "diffuse");
    CHECK(file.header(1).channels().findChannel("diffuse.G") != nullptr);
    CHECK(file.header(4).name() == "z");
    REQUIRE(file.header(4).channels().findChannel("Z") != nullptr);
    CHECK(file.header(4).channels().findChannel("Z")->type == Imf::FLOAT);
    CHECK(file.header(5).channels().findChannel("Nn.Z") != nullptr);
    CHECK(file.header(6).channels().findChannel("VLen") != nullptr);
    REQUIRE(file.header(7).channels().findChannel("id") != nullptr);
    CHECK(file.header(7).channels().findChannel("id")->type == Imf::UINT);
    CHECK(file.header(0).typedAttribute<Imf::IntAttribute>("nuke/full_layer_names").value() == 1);
    for (int part = 0; part < file.parts(); ++part) {
        CAPTURE(part);
        CHECK(file.header(part).compression() == (part == 7 ? Imf::ZIPS_COMPRESSION : Imf::ZIP_COMPRESSION));
        CHECK(text(part, "colorInteropID") == (part < 4 ? "lin_ap1_scene" : "data"));
        CHECK(Imf::chromaticities(file.header(part)).white.x == 0.32168f);
        CHECK(text(part, "raylex/seed") == "7");
        CHECK(text(part, "software") == "raylex 0.1");
        CHECK(text(part, "raylex/config").size() == (part == 0 ? 3000 : std::string("(none)").size()));
        CHECK(text(part, "raylex/incomplete") == "(none)");
    }
    for (const int part : {0, 1}) CHECK(text(part, "lpe/diffuse") == "C<RD>[<L.>O]");
    CHECK(text(2, "lpe/diffuse") == "(none)");
    CHECK(text(2, "lpeDialect/specular") == "osl");
    CHECK(text(0, "lpe/rest") == "rest of diffuse + specular");
    CHECK(text(0, "partition/auto") == "beauty = diffuse + specular + rest");
    CHECK(text(4, "rule/z") == "zmin");
    CHECK(text(5, "space/Nn") == "camera");
    CHECK(text(1, "rule/diffuse") == "filter");
    CHECK(text(1, "storage/diffuse") == "float zip");
    CHECK(text(0, "storage/id") == "uint zips");

    // A point's camera coordinates, and its position in the image, by OpenEXR's row vectors.
    Imath::V3f camera, ndc;
    Imf::worldToCamera(file.header(0)).multVecMatrix(Imath::V3f(1, 2, 3), camera);
    CHECK(camera == Imath::V3f(11, 22, 33));
    const Imath::M44f to_ndc = Imf::worldToNDC(file.header(0));
    to_ndc.multVecMatrix(Imath::V3f(-1, 1, 2), ndc);  // 45 degrees up and to the left of the axis: the corner
    CHECK(ndc.x == 0);
    CHECK(ndc.y == 0);
    to_ndc.multVecMatrix(Imath::V3f(0, -1, 2), ndc);
    CHECK(ndc.x == 0.5f);
    CHECK(ndc.y == 1);
}

TEST_CASE("misses are infinite where the design specifies it, and nothing else is", "[display][exr][law6]") {
    const Folder folder;
    const ExrImage image = written(folder);
    for (std::size_t i = 0; i < width * height; ++i) {
        CAPTURE(i);
        CHECK(std::isinf(image.layer("z")->planes[0].values[i]) == (i % 3 == 0));
        // 1e300 is a number: it becomes the largest float, and the header reports this.
        CHECK(image.layer("VLen")->planes[0].values[i] ==
              (i % 3 == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::max()));
        for (const ImagePlane& plane : image.layer("Nn")->planes) CHECK(std::isfinite(plane.values[i]));
    }
    CHECK(image.attributes.at("repaired/VLen") ==
          "0 values not a number, set to 0; 10 beyond float, set to the largest");
    CHECK(image.attributes.count("repaired/z") == 0);
}

TEST_CASE("integer channels keep all 32 bits", "[display][exr]") {
    const Folder folder;
    written(folder);
    Imf::MultiPartInputFile file(folder.path("a.exr").c_str());
    std::vector<unsigned> ids(width * height);
    Imf::FrameBuffer buffer;
    buffer.insert("id", Imf::Slice(Imf::UINT, reinterpret_cast<char*>(ids.data()), 4, 4 * width));
    Imf::InputPart part(file, 7);
    part.setFrameBuffer(buffer);
    part.readPixels(0, height - 1);
    CHECK(ids[0] == 0);
    CHECK(ids[1] == 4'294'967'294u);  // -2
    CHECK(ids[2] == 16'777'217u);
}

TEST_CASE("the same frame buffer gives the same bytes", "[display][exr][law3]") {
    const Folder folder;
    REQUIRE(write_exr(folder.path("a.exr"), filled(), beauty_id, description()).ok());
    REQUIRE(write_exr(folder.path("b.exr"), filled(), beauty_id, description()).ok());
    CHECK(read_bytes(folder.path("a.exr")) == read_bytes(folder.path("b.exr")));
}

TEST_CASE("an image without beauty and an incomplete image are written, and the header says so", "[display][exr]") {
    const Folder folder;
    ImageDescription unfinished = description();
    unfinished.complete = false;
    REQUIRE(write_exr(folder.path("a.exr"), filled(), invalid_channel, unfinished).ok());
    const auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image.ok());
    CHECK(image->attributes.at("raylex/incomplete") == "true");
    CHECK(image->layer("")->name == "beauty");  // the channel with that name, in a part of its own, without alpha
    CHECK(image->layer("")->planes.size() == 3);

    const std::vector<ChannelDefinition> one{plain("z", ChannelType::real, "camera")};
    REQUIRE(write_exr(folder.path("z.exr"), FrameBuffer({2, 2}, one), invalid_channel, {}).ok());
    CHECK(read_exr(folder.path("z.exr"))->layer_names() == std::vector<std::string>{"z"});
}

TEST_CASE("names that the format cannot store are refused before rendering", "[display][exr][law7]") {
    const auto message = [](std::vector<ChannelDefinition> list, ChannelId beauty,
                            std::vector<PartitionDeclaration> partitions = {}) {
        const auto status = check_exr_layout(list, beauty, partitions);
        return status.ok() ? std::string() : status.error().message;
    };
    CHECK(message(channels(), beauty_id, description().partitions).empty());
    CHECK(message({expression("a", "C.*"), expression("a", "CD")}, -1).find("used twice") != std::string::npos);
    CHECK(message({expression("beauty", ""), expression("rgba", "CD")}, 0).find("reserved for the beauty") !=
          std::string::npos);
    CHECK(message({expression("Ci", ""), expression("beauty", "CD")}, 0).find("reserved for the beauty") !=
          std::string::npos);
    CHECK(message({expression("", "C.*")}, -1).find("no name") != std::string::npos);
    CHECK(message({expression(std::string(244, 'n'), "C.*")}, -1).empty());
    CHECK(message({expression(std::string(245, 'n'), "C.*")}, -1).find("245") != std::string::npos);
    CHECK(message({expression("a + b", "C.*")}, -1).find("a + b") != std::string::npos);
    CHECK(message({expression("a\nb", "C.*")}, -1).find("control character") != std::string::npos);
    CHECK(message({}, -1).find("no channel to write") != std::string::npos);
    CHECK(message(channels(), 0, {{"p", "", {"difuse"}}}).find("'difuse'") != std::string::npos);
    CHECK(message({expression("a", "C.*")}, -1, {{"p", "", {"a"}}}).find("'beauty'") != std::string::npos);

    const Folder folder;
    const std::vector<ChannelDefinition> longest{expression(std::string(244, 'n'), "C.*")};
    REQUIRE(write_exr(folder.path("a.exr"), FrameBuffer({2, 2}, longest), invalid_channel, {}).ok());
    CHECK(read_exr(folder.path("a.exr"))->layer_names() == std::vector<std::string>{longest[0].name});
    Imf::MultiPartInputFile file(folder.path("a.exr").c_str());
    for (auto i = file.header(0).begin(); i != file.header(0).end(); ++i) CHECK(std::string(i.name()).size() <= 255);
}

TEST_CASE("an invalid partition does not prevent writing the image", "[display][exr][law7]") {
    const Folder folder;
    ImageDescription wrong = description();
    wrong.partitions.push_back({"typo", "", {"difuse"}});
    REQUIRE(write_exr(folder.path("a.exr"), filled(), beauty_id, wrong).ok());
    const auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image.ok());
    CHECK(image->partitions.size() == 1);
    CHECK(image->attributes.at("raylex/refusedPartition").find("difuse") != std::string::npos);
}

TEST_CASE("a failed write names path and reason, keeps the earlier file and leaves nothing else",
          "[display][exr][law7]") {
    const Folder folder;
    const std::string path = folder.path("a.exr");
    const auto failure = [](const std::string& target) {
        const auto status = write_exr(target, filled(), beauty_id, description());
        REQUIRE(!status.ok());
        CHECK(status.error().file == target);
        return status.error().message;
    };
    CHECK(failure(folder.path("no/a.exr")).find("No such file or directory") != std::string::npos);
    CHECK(failure(folder.path()).find("directory") != std::string::npos);
    CHECK(failure("/dev/null").find("device") != std::string::npos);
    CHECK(folder.names().size() == 0);

    REQUIRE(write_exr(path, filled(), beauty_id, description()).ok());
    const std::string earlier = read_bytes(path);
    REQUIRE(earlier.size() > 4000);
    for (const rlim_t limit : {rlim_t{0}, rlim_t{1000}, static_cast<rlim_t>(earlier.size() - 1)}) {
        CAPTURE(limit);
        const FileSizeLimit full(limit);
        CHECK(failure(path).find("File too large") != std::string::npos);
        CHECK(read_bytes(path) == earlier);
        CHECK(folder.names().size() == 1);
    }

    // The names are checked last: an image that cannot be written must not change an existing file.
    const std::vector<ChannelDefinition> twice{expression("a", "C.*"), expression("a", "CD")};
    CHECK(!write_exr(path, FrameBuffer({2, 2}, twice), invalid_channel, {}).ok());
    // OpenEXR itself refuses an attribute that is reserved by the format.
    ImageDescription reserved = description();
    reserved.attributes["compression"] = "none";
    CHECK(!write_exr(path, filled(), beauty_id, reserved).ok());
    CHECK(read_bytes(path) == earlier);
    CHECK(folder.names().size() == 1);
}
