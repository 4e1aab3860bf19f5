#include "display/drivers/packet_sender.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>

#include "display/services/thread_or_none.h"

namespace raylex::display {

namespace {

constexpr int poll_milliseconds = 100;  // reaction time of the thread to a stop

class Socket {
  public:
    Socket() = default;
    explicit Socket(int descriptor) : descriptor_(descriptor) {}
    ~Socket() { reset(); }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;
    void reset(int descriptor = -1) {
        if (descriptor_ >= 0) close(descriptor_);
        descriptor_ = descriptor;
    }
    [[nodiscard]] int get() const { return descriptor_; }

  private:
    int descriptor_ = -1;
};

}  // namespace

struct PacketSender::State {
    std::string host;
    int port = 0;
    std::size_t capacity = 0;

    mutable std::mutex mutex;
    std::condition_variable changed;
    std::deque<std::vector<unsigned char>> queue;
    std::size_t queued_bytes = 0;  // includes the packet being sent
    bool sending = false;
    std::string failure;
    std::atomic<bool> stop{false};
    std::atomic<std::size_t> sent_bytes{0};

    void fail(const std::string& why) {
        const std::lock_guard lock(mutex);
        if (failure.empty()) failure = why;
        queue.clear();
        queued_bytes = 0;
        sending = false;
        changed.notify_all();
    }
    bool wait_for(int descriptor, short events, double seconds) const;
    bool connect(Socket& socket);
    bool connect_to(Socket& socket, const addrinfo& address);
    bool send_all(int descriptor, const std::vector<unsigned char>& packet);
    void run();
};

/// Waits until the descriptor is ready, `seconds` have passed, or the sender stops.
bool PacketSender::State::wait_for(int descriptor, short events, double seconds) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!stop && std::chrono::steady_clock::now() < deadline) {
        pollfd each{descriptor, events, 0};
        const int ready = poll(&each, 1, poll_milliseconds);
        if (ready > 0) return true;
        if (ready < 0 && errno != EINTR) return false;
    }
    return false;
}

bool PacketSender::State::connect_to(Socket& socket, const addrinfo& address) {
    socket.reset(::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (socket.get() < 0) return false;
    if (::connect(socket.get(), address.ai_addr, address.ai_addrlen) != 0) {
        if (errno != EINPROGRESS) return false;
        if (!wait_for(socket.get(), POLLOUT, connect_seconds)) {
            errno = ETIMEDOUT;
            return false;
        }
        int error = 0;
        socklen_t size = sizeof error;
        getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size);
        errno = error;
        if (error != 0) return false;
    }
    const int on = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return true;
}

bool PacketSender::State::connect(Socket& socket) {
    addrinfo hints{};
    hints.ai_family = AF_UNSPEC;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* addresses = nullptr;
    if (const int failed = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &addresses); failed != 0) {
        fail(gai_strerror(failed));
        return false;
    }
    int reason = EHOSTUNREACH;
    bool connected = false;
    for (const addrinfo* each = addresses; each != nullptr && !connected && !stop; each = each->ai_next) {
        connected = connect_to(socket, *each);
        if (!connected) reason = errno;
    }
    freeaddrinfo(addresses);
    if (!connected) fail(std::generic_category().message(reason));
    return connected;
}

bool PacketSender::State::send_all(int descriptor, const std::vector<unsigned char>& packet) {
    std::size_t sent = 0;
    while (sent < packet.size()) {
        const ssize_t count = ::send(descriptor, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
        if (count > 0) {
            sent += static_cast<std::size_t>(count);
            sent_bytes += static_cast<std::size_t>(count);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) {
            // A slow viewer blocks only this thread.
            while (!stop && !wait_for(descriptor, POLLOUT, 1)) {}
            if (stop) return false;
        } else {
            fail("the connection broke: " + std::generic_category().message(errno));
            return false;
        }
    }
    return true;
}

void PacketSender::State::run() {
    Socket socket;
    if (!connect(socket)) return;
    while (true) {
        std::vector<unsigned char> packet;
        {
            std::unique_lock lock(mutex);
            changed.wait(lock, [&] { return stop || !queue.empty(); });
            if (stop) return;
            packet = std::move(queue.front());
            queue.pop_front();
            sending = true;
        }
        if (!send_all(socket.get(), packet)) return;
        const std::lock_guard lock(mutex);
        queued_bytes -= packet.size();
        sending = false;
        changed.notify_all();
    }
}

PacketSender::PacketSender(const std::string& host, int port, std::size_t capacity)
    : state_(std::make_shared<State>()) {
    state_->host = host;
    state_->port = port;
    state_->capacity = capacity;
    std::thread thread = thread_or_none([state = state_] { state->run(); });
    if (thread.joinable()) thread.detach();
    else state_->fail("the system cannot start another thread");
}

PacketSender::~PacketSender() {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
    state_->changed.notify_all();
}

bool PacketSender::send(std::vector<unsigned char> packet) {
    const std::lock_guard lock(state_->mutex);
    if (!state_->failure.empty()) return true;
    if (state_->queued_bytes != 0 && state_->queued_bytes + packet.size() > state_->capacity) return false;
    state_->queued_bytes += packet.size();
    state_->queue.push_back(std::move(packet));
    state_->changed.notify_all();
    return true;
}

bool PacketSender::drain(double stalled_seconds, double longest_seconds) {
    const auto empty = [&] { return state_->queue.empty() && !state_->sending; };
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(longest_seconds);
    std::unique_lock lock(state_->mutex);
    std::size_t sent_before = 0;
    do {
        sent_before = state_->sent_bytes;
        if (state_->changed.wait_for(lock, std::chrono::duration<double>(stalled_seconds), empty))
            return state_->failure.empty();
    } while (state_->sent_bytes != sent_before && std::chrono::steady_clock::now() < deadline);
    return false;
}

std::string PacketSender::failure() const {
    const std::lock_guard lock(state_->mutex);
    return state_->failure;
}

}  // namespace raylex::display
