// The receiving end of a viewer. It decodes the documented protocol independently of the sender's code.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace raylex::test {

struct ViewedImage {
    int width = 0, height = 0, updates = 0;
    std::map<std::string, std::vector<float>> channels;  ///< [name][y * width + x]
    std::vector<std::string> order;
};

class TevReceiver {
  public:
    enum class Manner { reads, never_reads, leaves };

    /// Listens on the loopback; `leaves` closes the connection after the first packet.
    explicit TevReceiver(Manner manner = Manner::reads) : manner_(manner) {
        listener_ = socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        const int small = 4096;  // a viewer that does not read must have an effect soon; it would slow down one that
                                 // reads
        if (manner_ != Manner::reads) setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
        if (bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 || listen(listener_, 1) != 0 ||
            getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
            std::abort();
        port_ = ntohs(address.sin_port);
        thread_ = std::thread([this] { run(); });
    }
    ~TevReceiver() {
        stop_ = true;
        thread_.join();
        close(listener_);
    }
    TevReceiver(const TevReceiver&) = delete;
    TevReceiver& operator=(const TevReceiver&) = delete;

    [[nodiscard]] int port() const { return port_; }
    [[nodiscard]] std::map<std::string, ViewedImage> images() {
        const std::lock_guard lock(mutex_);
        return images_;
    }
    [[nodiscard]] std::string complaint() {
        const std::lock_guard lock(mutex_);
        return complaint_;
    }

  private:
    struct Reader {
        const unsigned char* at;
        const unsigned char* end;
        bool bad = false;

        template <class T>
        T number() {
            T value{};
            if (static_cast<std::size_t>(end - at) < sizeof value) {
                bad = true;
                return value;
            }
            std::memcpy(&value, at, sizeof value);  // the test machines are little-endian, like the protocol
            at += sizeof value;
            return value;
        }
        std::string text() {
            const auto* zero =
                static_cast<const unsigned char*>(std::memchr(at, 0, static_cast<std::size_t>(end - at)));
            if (zero == nullptr) {
                bad = true;
                return {};
            }
            std::string value(at, zero);
            at = zero + 1;
            return value;
        }
        std::vector<std::string> texts() {
            std::vector<std::string> values;
            const auto count = number<std::int32_t>();
            for (std::int32_t i = 0; i < count && !bad; ++i) values.push_back(text());
            return values;
        }
    };

    void complain(const std::string& text) {
        if (complaint_.empty()) complaint_ = text;
    }

    void decode(const std::vector<unsigned char>& packet) {
        const std::lock_guard lock(mutex_);
        Reader reader{packet.data() + 4, packet.data() + packet.size()};
        const auto type = reader.number<std::uint8_t>();
        reader.number<std::uint8_t>();  // focus
        const std::string name = reader.text();
        if (type == 4) {
            ViewedImage image;
            image.width = reader.number<std::int32_t>();
            image.height = reader.number<std::int32_t>();
            image.order = reader.texts();
            for (const std::string& channel : image.order)
                image.channels[channel].resize(static_cast<std::size_t>(image.width * image.height));
            images_[name] = image;
        } else if (type == 6) {
            const std::vector<std::string> channels = reader.texts();
            const auto x = reader.number<std::int32_t>(), y = reader.number<std::int32_t>();
            const auto width = reader.number<std::int32_t>(), height = reader.number<std::int32_t>();
            std::vector<std::int64_t> offsets, strides;
            for (std::size_t i = 0; i < channels.size(); ++i) offsets.push_back(reader.number<std::int64_t>());
            for (std::size_t i = 0; i < channels.size(); ++i) strides.push_back(reader.number<std::int64_t>());
            const auto floats = (reader.end - reader.at) / 4;
            if (images_.count(name) == 0) return complain("update of an unknown image");
            ViewedImage& image = images_[name];
            if (x < 0 || y < 0 || x + width > image.width || y + height > image.height)
                return complain("update outside the image");
            ++image.updates;
            for (std::size_t c = 0; c < channels.size(); ++c) {
                if (image.channels.count(channels[c]) == 0) return complain("update of an unknown channel");
                std::vector<float>& plane = image.channels[channels[c]];
                for (std::int64_t i = 0; i < std::int64_t{width} * height; ++i) {
                    const std::int64_t index = offsets[c] + i * strides[c];
                    if (index < 0 || index >= floats) return complain("pixels beyond the packet");
                    float value;
                    std::memcpy(&value, reader.at + 4 * index, 4);
                    plane[static_cast<std::size_t>((y + i / width) * image.width + x + i % width)] = value;
                }
            }
            reader.at = reader.end;
        } else {
            complain("a packet of unknown type");
        }
        if (reader.bad || reader.at != reader.end) complain("a packet's length does not fit its fields");
    }

    bool wait(int descriptor) const {
        while (!stop_) {
            pollfd each{descriptor, POLLIN, 0};
            if (poll(&each, 1, 20) > 0) return true;
        }
        return false;
    }

    bool read(int descriptor, unsigned char* to, std::size_t count) const {
        while (count > 0) {
            if (!wait(descriptor)) return false;
            const ssize_t got = recv(descriptor, to, count, 0);
            if (got <= 0) return false;
            to += got;
            count -= static_cast<std::size_t>(got);
        }
        return true;
    }

    void run() {
        if (!wait(listener_)) return;
        const int connection = accept(listener_, nullptr, nullptr);
        while (manner_ == Manner::never_reads && !stop_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        while (!stop_) {
            std::vector<unsigned char> packet(4);
            if (!read(connection, packet.data(), 4)) break;
            std::uint32_t length;
            std::memcpy(&length, packet.data(), 4);
            if (length < 5) return complain("a packet too short");
            packet.resize(length);
            if (!read(connection, packet.data() + 4, length - 4)) break;
            decode(packet);
            if (manner_ == Manner::leaves) break;
        }
        close(connection);
    }

    Manner manner_;
    int listener_ = -1, port_ = 0;
    std::atomic<bool> stop_{false};
    std::thread thread_;
    std::mutex mutex_;
    std::map<std::string, ViewedImage> images_;
    std::string complaint_;
};

}  // namespace raylex::test
