// Sends packets over TCP from a thread of its own, so that callers never wait.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace raylex::display {

class PacketSender {
  public:
    /// Connects in the background, for at most connect_seconds. At most `capacity` bytes are queued.
    PacketSender(const std::string& host, int port, std::size_t capacity);
    /// Does not wait for packets that are not sent yet.
    ~PacketSender();
    PacketSender(const PacketSender&) = delete;
    PacketSender& operator=(const PacketSender&) = delete;

    /// Queues a packet. Returns false if there is no room; a single packet always fits into an empty queue. After a
    /// failure packets are accepted and discarded.
    bool send(std::vector<unsigned char> packet);
    /// Waits until every packet is handed to the system. Gives up, and returns false, once the viewer has accepted
    /// nothing for `stalled_seconds`, or after `longest_seconds`.
    bool drain(double stalled_seconds, double longest_seconds);
    /// Why packets no longer arrive; empty while they do.
    [[nodiscard]] std::string failure() const;

    static constexpr double connect_seconds = 3;

  private:
    struct State;
    std::shared_ptr<State> state_;  // the thread can outlive this object while a name is looked up
};

}  // namespace raylex::display
