// Sends packets over TCP from a thread of its own: whoever hands them over never waits.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace raylex::display {

class PacketSender {
  public:
    /// Connects in the background, for at most connect_seconds. At most `capacity` bytes wait to be sent.
    PacketSender(const std::string& host, int port, std::size_t capacity);
    /// Does not wait for what is not sent yet.
    ~PacketSender();
    PacketSender(const PacketSender&) = delete;
    PacketSender& operator=(const PacketSender&) = delete;

    /// False when there is no room; a single packet always fits into an empty queue. Packets after a failure are taken
    /// and forgotten.
    bool send(std::vector<unsigned char> packet);
    /// Waits until everything was handed to the system, for at most `seconds`; false when it was not.
    bool drain(double seconds);
    /// Why packets are not arriving any more; empty while they are.
    [[nodiscard]] std::string failure() const;

    static constexpr double connect_seconds = 3;

  private:
    struct State;
    std::shared_ptr<State> state_;  // the thread may outlive this object while a name is looked up
};

}  // namespace raylex::display
