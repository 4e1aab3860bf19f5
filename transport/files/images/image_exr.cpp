#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>

#include <exception>

#include "display/output/reader/exr_guard.h"
#include "transport/color/color_space.h"
#include "transport/files/images/image_readers.h"

namespace raylex::transport {

namespace {

/// Names of the channels to read, in interleaved order; empty if raylex does not support the layout.
std::vector<std::string> choose_channels(const Imf::ChannelList& channels) {
    const auto has = [&channels](const char* name) { return channels.findChannel(name) != nullptr; };
    std::vector<std::string> names;
    if (has("R") && has("G") && has("B")) names = {"R", "G", "B"};
    else if (has("Y")) names = {"Y"};
    if (!names.empty() && has("A")) names.emplace_back("A");
    if (!names.empty()) return names;
    std::size_t count = 0;
    for (auto it = channels.begin(); it != channels.end(); ++it) ++count;
    if (count == 1) names.emplace_back(channels.begin().name());
    return names;
}

void read_space(const Imf::Header& header, Image& image) {
    if (image.channels < 3 || !Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    const auto xy = [](const Imath::V2f& v) { return Chromaticity{double{v.x}, double{v.y}}; };
    const auto known = color_space_of({xy(c.red), xy(c.green), xy(c.blue)}, xy(c.white));
    image.other_space = !known;
    if (known) image.space = *known;
}

Result<Image> read_channels(const std::string& path) {
    Imf::InputFile file(path.c_str());
    const Imf::ChannelList& channels = file.header().channels();
    const std::vector<std::string> names = choose_channels(channels);
    if (names.empty()) {
        std::string list;
        for (auto it = channels.begin(); it != channels.end(); ++it)
            list.append(list.empty() ? "" : " ").append(it.name());
        return Error{"OpenEXR image has channels " + list + "; expected R G B, Y or a single one", path, 0, 0, {}, {}};
    }
    for (const std::string& name : names)
        if (channels[name.c_str()].xSampling != 1 || channels[name.c_str()].ySampling != 1)
            return Error{
                "OpenEXR channel '" + name + "' is subsampled; expected one sample per pixel", path, 0, 0, {}, {}};
    const auto window = file.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1,
                       height = std::int64_t{window.max.y} - window.min.y + 1;
    constexpr std::int64_t most = std::int64_t{1} << 31;  // samples
    if (width <= 0 || height <= 0 || width > most / height / static_cast<std::int64_t>(names.size()))
        return Error{"OpenEXR image is empty or beyond 2^31 samples", path, 0, 0, {}, {}};

    Image image;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.channels = static_cast<int>(names.size());
    image.pixels.resize(static_cast<std::size_t>(width * height) * names.size());
    Imf::FrameBuffer target;
    for (std::size_t c = 0; c < names.size(); ++c)
        target.insert(names[c],
                      Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, window, sizeof(float) * names.size(),
                                       sizeof(float) * names.size() * static_cast<std::size_t>(width)));
    file.setFrameBuffer(target);
    file.readPixels(window.min.y, window.max.y);
    read_space(file.header(), image);
    return image;
}

}  // namespace

Result<Image> read_exr_image(const std::string& path) {
    if (Status sound = display::check_exr_file(path); !sound) return sound.error();
    try {
        return read_channels(path);
    } catch (const std::exception& exception) {
        return Error{std::string("corrupt or unreadable OpenEXR file: ") + exception.what(), path, 0, 0, {}, {}};
    }
}

}  // namespace raylex::transport
