#include "display/drivers/tev_protocol.h"

#include <bit>

namespace raylex::display::tev {

namespace {

class Writer {
  public:
    explicit Writer(unsigned char type) {
        number<std::uint32_t>(0);  // the length, filled in at the end
        byte(type);
    }
    void byte(unsigned char value) { packet_.push_back(value); }
    template <class Unsigned>
    void number(Unsigned value) {
        for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
            packet_.push_back(static_cast<unsigned char>(value >> (8 * i) & 0xffu));
    }
    void int32(int value) { number(static_cast<std::uint32_t>(value)); }
    void text(const std::string& value) {
        packet_.insert(packet_.end(), value.begin(), value.end());
        byte(0);
    }
    void texts(const std::vector<std::string>& values) {
        int32(static_cast<int>(values.size()));
        for (const std::string& value : values) text(value);
    }
    void reserve(std::size_t more) { packet_.reserve(packet_.size() + more); }
    Packet finish() {
        const auto length = static_cast<std::uint32_t>(packet_.size());
        for (std::size_t i = 0; i < 4; ++i) packet_[i] = static_cast<unsigned char>(length >> (8 * i) & 0xffu);
        return std::move(packet_);
    }

  private:
    Packet packet_;
};

}  // namespace

Packet create_image(const std::string& name, int width, int height, const std::vector<std::string>& channels) {
    Writer writer(4);
    writer.byte(1);  // show it at once
    writer.text(name);
    writer.int32(width);
    writer.int32(height);
    writer.texts(channels);
    return writer.finish();
}

Packet update_image(const std::string& name, const std::vector<std::string>& channels, const PixelRegion& region,
                    std::span<const float> values) {
    Writer writer(6);
    writer.byte(0);  // do not take the focus from another image
    writer.text(name);
    writer.texts(channels);
    for (const int each : {region.x0, region.y0, region.width(), region.height()}) writer.int32(each);
    for (std::uint64_t i = 0; i < channels.size(); ++i) writer.number(i);
    for (std::size_t i = 0; i < channels.size(); ++i) writer.number(static_cast<std::uint64_t>(channels.size()));
    writer.reserve(4 * values.size());
    for (const float value : values) writer.number(std::bit_cast<std::uint32_t>(value));
    return writer.finish();
}

}  // namespace raylex::display::tev
