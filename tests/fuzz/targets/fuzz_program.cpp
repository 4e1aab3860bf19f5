// Any bytes as a compiled program's file. Nearly all inputs fail at the hash, so the target writes the right one over
// the last 8 bytes: then the checks of every index have to hold, and paths are followed through what was read.
#include "lpe/adopt/program_file.h"
#include "lpe/program.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    std::string bytes(reinterpret_cast<const char*>(data), size);
    if (size >= 8) {
        std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a, 64 bits (Fowler, Noll, Vo)
        for (std::size_t i = 0; i + 8 < size; ++i) hash = (hash ^ data[i]) * 0x100000001B3ULL;
        for (std::size_t i = 0; i < 8; ++i) bytes[size - 8 + i] = static_cast<char>(hash >> (8 * i) & 0xFF);
    }
    const auto program = program_from_bytes(bytes, "fuzzed");
    if (!program) {
        fuzz::require(!program.error().message.empty(), "a refusal says why");
        return 0;
    }
    const ProgramView view = program->view();
    std::vector<State> states(view.starts, view.starts + view.word_count);
    for (std::uint32_t event = 0; event < view.class_count && event < 64; ++event) {
        view.advance(states.data(), static_cast<EventClass>(event), states.data());
        view.for_each_accepted(states.data(), [&](std::uint16_t channel) {
            fuzz::require(channel < view.channel_count, "channels exist");
        });
    }
    return 0;
}
